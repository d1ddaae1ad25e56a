"""``bt-manip run``: run a tree in a cell."""

from dataclasses import replace
from typing import TYPE_CHECKING

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.exit_codes import FAILED, FAULT, SUCCESS, exit_code_help
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.json_output import json_option, print_json
from bt_manip.cli.options import takes
from bt_manip.cli.run_options import RunOptions
from bt_manip.cli.view_options import ModifiedCommand

if TYPE_CHECKING:
    from bt_manip.cli.run_job import RunJob


class RunCommand(ModifiedCommand):
    """A command with the options of views and modifiers."""

    brings = ("views", "modifiers")


_EPILOG = exit_code_help({
    SUCCESS: "every cycle succeeded",
    FAILED: "a cycle failed",
    FAULT: "an internal fault (a plugin raised, the physics diverged, a file could not be written)",
})  # fmt: skip


@click.command(
    cls=RunCommand,
    epilog=f"{_EPILOG} Output that cannot be printed, as to a closed pipe, changes none of them.",
)
@click.argument("tree", shell_complete=complete_part("trees"))
@json_option
@takes(RunOptions)
@click.pass_obj
def run(interrupt: Interrupt, options: RunOptions, as_json: bool) -> int:
    """Run TREE in a cell.

    TREE is a registered name (see: bt-manip list trees), path.xml, path.xml:TREE, path.py:NAME or
    package.module:NAME, where NAME is a tree or a function that returns one.
    """
    from bt_manip.cli.session import execute_run

    if as_json:
        return execute_run(replace(options, quiet=True), interrupt, ended=_print_report)
    return execute_run(options, interrupt)


def _print_report(job: "RunJob") -> None:
    assert job.report is not None
    print_json(() if job.run is None else job.run.tree.warnings, report=job.report.plain())
