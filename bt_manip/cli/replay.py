"""``bt-manip replay``: show a recorded run on a page, or simulate on from one of its moments."""

import os
from dataclasses import replace
from pathlib import Path

import click

from bt_manip.cli.exit_codes import BAD_INPUT, SUCCESS, exit_code_help
from bt_manip.cli.foreign_trees import ForeignTrees
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.options import given_options, takes
from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.cli.run_options import RunOptions
from bt_manip.cli.streams import unfailing
from bt_manip.exceptions import BtManipError, require_extra

WATCHING = ("real_time", "window", "view", "report", "records", "quiet")
"""Options of ``bt-manip run`` that ``--continue`` takes, too."""

RECORDED = ("tree", "cycles", "seed", "robot", "controller", "scene", "planner", "settings")
"""Fields of a recorded request that are options of ``bt-manip run``."""


@click.command(
    epilog=exit_code_help(
        {SUCCESS: "after Ctrl-C, which ends it", BAD_INPUT: "bad input"}, common={}
    )
    + " With --continue they are those of bt-manip run."
)
@click.argument("recording", type=click.Path(path_type=Path), metavar="FILE.mcap")
@click.option(
    "--from", "start", type=float, metavar="T",
    help="Simulated time that is shown at first [s].  [default: the start of the run]",
)  # fmt: skip
@click.option(
    "--speed", type=click.FloatRange(min=0.0, min_open=True), default=1.0, show_default=True,
    metavar="X", help="Simulated seconds per second of wall time at first.",
)  # fmt: skip
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8080, show_default=True, metavar="PORT",
    help="The first port that is tried; 0 lets the system choose.",
)  # fmt: skip
@click.option(
    "--continue", "moment", type=float, metavar="T",
    help="Simulate on from this simulated time [s], with the recorded interventions; the options "
    "below are those of bt-manip run.",
)  # fmt: skip
@takes(RunOptions, only=WATCHING)
@click.pass_obj
def replay(
    interrupt: Interrupt,
    recording: Path,
    start: float | None,
    speed: float,
    port: int,
    moment: float | None,
    options: RunOptions,
) -> int:
    """Show a recorded run on a page in the browser, at any of its times."""
    require_extra("record", "replay", "mcap", "foxglove_schemas_protobuf")
    if moment is not None:
        with unfailing("stdout"):
            return _continue_run(recording, moment, interrupt, options)
    for name in given_options(replace(options, view=False)):
        raise BtManipError(f"{name} needs --continue T")
    require_extra("view", "replay", "viser")
    os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here
    from bt_manip.record import Recording

    opened = Recording(recording)
    if start is not None and start > opened.end:
        raise BtManipError(f"{recording} ends at {opened.end:.3f} s, before {start:g} s")
    from bt_manip.cli.run_observers import page_panels
    from bt_manip.viewer import ReplayPage

    panels = page_panels(load_chosen_plugins())
    page = ReplayPage(opened, panels, port=port, start=start, speed=speed)
    try:
        with interrupt.held():
            click.echo(f"The page of the recording: {page.url}; press Ctrl-C to leave.")
            page.serve(lambda: interrupt.requested)
    finally:
        page.close()
    interrupt.exit_code = SUCCESS  # it is how this command ends
    return SUCCESS


def _continue_run(path: Path, time: float, interrupt: Interrupt, options: RunOptions) -> int:
    """Simulate a recorded run again up to a time [s], then go on as ``bt-manip run`` does.

    Raises:
        BtManipError: If the run cannot be continued from there.
    """
    from bt_manip.cli.page_session import execute_run
    from bt_manip.record import Continuation, Recording

    continued = Continuation(Recording(path), time)
    fields, identity = continued.fields, continued.recording.identity
    with continued.recording.decoding():
        options = replace(
            options,
            **{key: fields[key] for key in RECORDED},
            tick_ms=1e3 * fields["tick"],
            foreign=ForeignTrees.of(identity.get("foreign", {})),
            continued=continued,
        )
    return execute_run(options, interrupt)
