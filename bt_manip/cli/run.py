"""``bt-manip run`` and ``bt-manip view``: run a tree in a cell, or choose trees on a page."""

from dataclasses import replace

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.exit_codes import FAILED, FAULT, INTERRUPTED, SUCCESS, exit_code_help
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.options import takes
from bt_manip.cli.run_options import RunOptions
from bt_manip.cli.streams import unfailing
from bt_manip.cli.view_options import ViewingCommand

OF_ONE_RUN = (
    "window", "view", "report", "trace", "records", "faults", "snapshots", "resume", "varied",
)  # fmt: skip
"""Options of ``bt-manip run`` that ``bt-manip view`` does not have."""

_EPILOG = exit_code_help({
    SUCCESS: "every cycle succeeded",
    FAILED: "a cycle failed",
    FAULT: "an internal fault (a plugin raised, the physics diverged, a file could not be written)",
})  # fmt: skip


@click.command(
    cls=ViewingCommand,
    epilog=f"{_EPILOG} Output that cannot be printed, as to a closed pipe, changes none of them.",
)
@click.argument("tree", shell_complete=complete_part("trees"))
@takes(RunOptions)
@click.pass_obj
def run(interrupt: Interrupt, options: RunOptions) -> int:
    """Run TREE in a cell.

    TREE is a registered name (see: bt-manip list trees), path.xml, path.py:NAME or
    package.module:NAME, where NAME is a tree or a function that returns one.
    """
    from bt_manip.cli.page_session import execute_run

    with unfailing("stdout"):
        return execute_run(options, interrupt)


@click.command(
    cls=ViewingCommand,
    epilog=exit_code_help({INTERRUPTED: "after Ctrl-C, which ends it"}),
)
@click.argument("tree", required=False, default="", shell_complete=complete_part("trees"))
@takes(RunOptions, without=OF_ONE_RUN)
@click.pass_obj
def view(interrupt: Interrupt, options: RunOptions) -> int:
    """Open a page to choose trees, run, stop and reset them, and to jog the robot.

    TREE, as for bt-manip run, is chosen at first; it runs when that is asked for on the page.
    """
    from bt_manip.cli.page_session import execute_on_page

    with unfailing("stdout"):
        return execute_on_page(replace(options, view=True), interrupt, run=False)
