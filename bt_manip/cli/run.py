"""``bt-manip run``: run a tree in a cell."""

from pathlib import Path
from typing import Any

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.foreign_trees import foreign_tree_options
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.settings import parse_settings
from bt_manip.cli.station_options import station_options
from bt_manip.cli.streams import unfailing

EXIT_CODES = (
    "Exit codes: 0 every cycle succeeded, 1 a cycle failed, 2 bad input, 3 an internal fault (a "
    "plugin raised, the physics diverged, a file could not be written), 130 interrupted. Output "
    "that cannot be printed, as to a closed pipe, changes none of them."
)


@click.command(epilog=EXIT_CODES)
@click.argument("tree", shell_complete=complete_part("trees"))
@click.option(
    "--cycles", default=1, show_default=True, metavar="N",
    help="Runs of the tree from idle to SUCCESS or FAILURE; 0 goes on until Ctrl-C.",
)  # fmt: skip
@click.option(
    "--episode", type=click.IntRange(min=0), metavar="N",
    help="Run episode N of bt-manip evaluate instead of cycles.",
)  # fmt: skip
@click.option(
    "--seed", type=int, metavar="S", help="Seed of all randomness.  [default: the scene's, or 0]"
)
@station_options
@click.option(
    "--configurations", type=click.Path(path_type=Path), metavar="FILE.toml",
    help="Named configurations for MoveToConfiguration, as the page saves them.",
)  # fmt: skip
@click.option(
    "--tick", "tick_ms", default=10.0, show_default=True, metavar="MS",
    help="Simulated time between two ticks of the tree [ms].",
)  # fmt: skip
@click.option(
    "--real-time", type=click.FloatRange(min=0.0), metavar="X",
    help="Simulated seconds per second of wall time; 0 is as fast as possible.  "
    "[default: 1 with --window, --view or --groot, else 0]",
)  # fmt: skip
@click.option(
    "--window", is_flag=True, help="Show the cell in a window, which stays open after the run."
)
@click.option(
    "--view", is_flag=True,
    help="Show the run on a page in the browser, which stays up after the run.",
)  # fmt: skip
@click.option(
    "--groot", is_flag=True,
    help="Let Groot2 on this computer monitor the run, set breakpoints and replace statuses.",
)  # fmt: skip
@click.option(
    "--groot-port", type=click.IntRange(1, 65534), default=1667, show_default=True, metavar="PORT",
    help="Port to which Groot2 connects; the next one must be free, too.",
)  # fmt: skip
@click.option(
    "--report", type=click.Path(path_type=Path), metavar="FILE",
    help="Write a report as JSON; FILE.jsonl gets a line as each cycle ends.",
)  # fmt: skip
@click.option(
    "--trace", type=click.Path(path_type=Path), metavar="FILE.npz",
    help="Write t, q, v, q_ref, v_ref, a_ref and tau of every control step.",
)  # fmt: skip
@click.option(
    "--record", "records", multiple=True, metavar="\"[NAME=]FILE KEY=VALUE ...\"",
    shell_complete=complete_part("recorders"),
    help="Add a recorder (see: bt-manip list recorders); FILE alone chooses the recorder of its "
    "suffix, as in run.mcap or run.mp4; KEY=VALUE are its options.  May be given more than once.",
)  # fmt: skip
@click.option(
    "--fault", "faults", multiple=True, metavar="\"NAME at=NODE KEY=VALUE ...\"",
    help="Inject a fault when a node of the tree starts (see: bt-manip list faults); may be given "
    "more than once.",
)  # fmt: skip
@click.option(
    "--snapshot-at", "snapshots", multiple=True, metavar="SECONDS FILE",
    type=(float, click.Path(path_type=Path)),
    help="Write a snapshot after this much simulated time; may be given more than once.",
)  # fmt: skip
@click.option(
    "--resume", type=click.Path(path_type=Path), metavar="FILE",
    help="Continue from a snapshot of a run with the same options.",
)  # fmt: skip
@click.option("--watch", is_flag=True, help="Reload the tree whenever its file changes.")
@click.option("--quiet", is_flag=True, help="Print nothing but warnings and errors.")
@foreign_tree_options
@click.pass_obj
def run(interrupt: Interrupt, settings: tuple[str, ...], **options: Any) -> int:
    """Run TREE in a cell.

    TREE is a registered name (see: bt-manip list trees), path.xml, path.py:NAME or
    package.module:NAME, where NAME is a tree or a function that returns one.
    """
    from bt_manip.cli.page_session import execute_run
    from bt_manip.cli.run_options import RunOptions

    with unfailing("stdout"):
        return execute_run(RunOptions(settings=parse_settings(settings), **options), interrupt)
