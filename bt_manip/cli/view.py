"""``bt-manip view``: a page in the browser on which trees are chosen, run and stopped."""

from typing import Any

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.foreign_trees import foreign_tree_options
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.run import run
from bt_manip.cli.settings import parse_settings
from bt_manip.cli.streams import unfailing

OF_ONE_RUN: dict[str, Any] = {
    "window": False, "view": True, "report": None, "trace": None, "records": (), "faults": (),
    "snapshots": (), "resume": None,
}  # fmt: skip
"""Options of ``bt-manip run`` that this command does not have, with their values."""


@click.command(epilog="Exit codes: 130 after Ctrl-C, which ends it; 2 bad input.")
@click.argument("tree", required=False, default="", shell_complete=complete_part("trees"))
@foreign_tree_options
@click.pass_obj
def view(interrupt: Interrupt, settings: tuple[str, ...], **options: Any) -> int:
    """Open a page to choose trees, run, stop and reset them, and to jog the robot.

    TREE, as for bt-manip run, is chosen at first; it runs when that is asked for on the page.
    """
    from bt_manip.cli.page_session import execute_on_page
    from bt_manip.cli.run_options import RunOptions

    chosen = RunOptions(settings=parse_settings(settings), **OF_ONE_RUN, **options)
    with unfailing("stdout"):
        return execute_on_page(chosen, interrupt, run=False)


_OWN = {parameter.name for parameter in view.params}
view.params += [one for one in run.params if one.name not in {*_OWN, *OF_ONE_RUN}]
