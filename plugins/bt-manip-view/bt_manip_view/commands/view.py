"""``bt-manip view``: choose trees on a page."""

import click

from bt_manip.cli import (
    INTERRUPTED,
    Interrupt,
    RunOptions,
    ViewingCommand,
    complete_part,
    execute_run,
    exit_code_help,
    takes,
)
from bt_manip_view.plugin import VIEW

OF_ONE_RUN = (
    "window", "report", "trace", "records", "snapshots", "resume", "varied",
)  # fmt: skip
"""Options of ``bt-manip run`` that ``bt-manip view`` does not have."""


@click.command(
    cls=ViewingCommand,
    always=(VIEW,),
    epilog=exit_code_help({INTERRUPTED: "after Ctrl-C, which ends it"}),
)
@click.argument("tree", required=False, default="", shell_complete=complete_part("trees"))
@takes(RunOptions, without=OF_ONE_RUN)
@click.pass_obj
def view(interrupt: Interrupt, options: RunOptions) -> int:
    """Open a page to choose trees, run, stop and reset them, and to jog the robot.

    TREE, as for bt-manip run, is chosen at first; it runs when that is asked for on the page.
    """
    return execute_run(options, interrupt, begin=False)
