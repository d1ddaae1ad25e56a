"""``bt-manip replay``: show a recorded run on a page, or simulate on from one of its moments."""

import os
from pathlib import Path

import click

from bt_manip.cli import (
    BAD_INPUT,
    SUCCESS,
    Interrupt,
    RunOptions,
    ViewingCommand,
    execute_run,
    exit_code_help,
    given_options,
    load_chosen_plugins,
    takes,
)
from bt_manip.exceptions import BtManipError
from bt_manip_view.plugin import VIEW

WATCHING = ("real_time", "window", "report", "records", "quiet")
"""Options of ``bt-manip run`` that ``--continue`` takes, too, beside those of views."""


@click.command(
    cls=ViewingCommand,
    epilog=exit_code_help(
        {SUCCESS: "after Ctrl-C, which ends it", BAD_INPUT: "bad input"}, common={}
    )
    + " With --continue they are those of bt-manip run.",
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
    "--breakpoints", default="", metavar="NODES",
    help="Names or paths of nodes, separated by ';', at whose start it pauses.",
)  # fmt: skip
@click.option(
    "--continue", "moment", type=float, metavar="T",
    help="Simulate on from this simulated time [s], with the recorded interventions; the options "
    "below are those of bt-manip run.",
)  # fmt: skip
@click.option(
    "--tree", "named", metavar="TREE",
    help="With --continue: the recorded tree, as of bt-manip run. A tree in Python must be named: "
    "its code runs if its file is the recorded one.",
)  # fmt: skip
@takes(RunOptions, only=WATCHING)
@click.pass_obj
def replay(
    interrupt: Interrupt,
    recording: Path,
    start: float | None,
    speed: float,
    port: int,
    breakpoints: str,
    moment: float | None,
    named: str | None,
    options: RunOptions,
) -> int:
    """Show a recorded run on a page in the browser, at any of its times."""
    from bt_manip_recording import Continuation, Recording

    if moment is not None:
        options = options.continuing(Continuation(Recording(recording), moment, named or ""))
        return execute_run(options, interrupt)
    others = [f"--{name}" for name in options.views if name != VIEW]  # a page is shown anyway
    others += ["--tree"] * (named is not None)
    for name in (*(words[0] for words in given_options(options)), *others):
        raise BtManipError(f"{name} needs --continue T")
    os.environ.setdefault("MUJOCO_GL", "disable")  # nothing is drawn here
    opened = Recording(recording)
    if start is not None and start > opened.end:
        raise BtManipError(f"{recording} ends at {opened.end:.3f} s, before {start:g} s")
    from bt_manip_view import ReplayPage
    from bt_manip_view.page.breakpoints import split_names
    from bt_manip_view.page.plugin_panels import page_panels

    panels = page_panels(load_chosen_plugins())
    page = ReplayPage(
        opened, panels, port=port, start=start, speed=speed, breakpoints=split_names(breakpoints)
    )
    try:
        with interrupt.held():
            click.echo(f"The page of the recording: {page.url}; press Ctrl-C to leave.")
            page.serve(lambda: interrupt.requested)
    finally:
        page.close()
    interrupt.exit_code = SUCCESS  # it is how this command ends
    return SUCCESS
