"""``bt-manip view``: a page in the browser on which trees are chosen, run and stopped."""

from dataclasses import replace

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.exit_codes import COMMON, INTERRUPTED, exit_code_help
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.options import takes
from bt_manip.cli.run_options import RunOptions
from bt_manip.cli.streams import unfailing

OF_ONE_RUN = (
    "window", "view", "report", "trace", "records", "faults", "snapshots", "resume", "varied",
)  # fmt: skip
"""Options of ``bt-manip run`` that this command does not have."""


@click.command(epilog=exit_code_help({**COMMON, INTERRUPTED: "after Ctrl-C, which ends it"}))
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
