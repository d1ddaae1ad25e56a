"""``bt-manip stress``: test how a tree copes with faults."""

import os
import shlex
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli import (
    FAILED,
    SUCCESS,
    GroupedCommand,
    StationOptions,
    chosen,
    complete_part,
    exit_code_help,
    given_options,
    json_option,
    load_chosen_plugins,
    print_json,
    print_warning,
    takes,
    workers_option,
)

if TYPE_CHECKING:
    from bt_manip_stress import StressEpisode, StressTable, StressTester

BEGIN, END = "<!-- stress -->", "<!-- /stress -->"
"""Lines of a page between which its table is."""


@click.command(
    cls=GroupedCommand,
    epilog=exit_code_help(
        {
            SUCCESS: "every cycle ended honestly and the next one reached its goal",
            FAILED: "one did not",
        }
    ),  # fmt: skip
)
@click.argument("tree", shell_complete=complete_part("trees"))
@click.option(
    "--seeds", type=click.IntRange(min=1), default=1, show_default=True, metavar="N",
    help="Number of seeds, from 0.",
)  # fmt: skip
@click.option("--faults", default="", metavar="A,B", help="Only these faults.  [default: all]")
@click.option(
    "--phases", default="", metavar="A,B",
    help="Only at these leaves.  [default: all that run in an undisturbed cycle]",
)  # fmt: skip
@workers_option
@click.option(
    "--markdown", type=click.Path(path_type=Path), metavar="FILE",
    help="Write the whole table to a page: between the lines <!-- stress --> and <!-- /stress -->, "
    "where it has them.",
)  # fmt: skip
@json_option
@takes(StationOptions)
def stress(
    tree: str,
    seeds: int,
    faults: str,
    phases: str,
    workers: int | None,
    markdown: Path | None,
    options: StationOptions,
    as_json: bool,
) -> int:
    """Test how TREE copes with faults.

    Each fault (see: bt-manip list faults) happens at each phase of the tree, an action leaf that
    runs in an undisturbed cycle, once for each seed. The physics judges whether the goal that the
    tree declares holds. After each cycle with a fault an undisturbed one must reach the goal.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.cli import run_tracked
    from bt_manip.evaluation import call_in_process
    from bt_manip.record import check_writable
    from bt_manip_stress import StressTable, StressTester, lost_stress

    if markdown is not None:
        check_writable(markdown, "table")
    load_chosen_plugins()  # warns of broken ones
    tester = partial(StressTester, tree, choice=chosen(), **options.request_fields)
    plan = partial(_plan, tester, seeds, _names(faults), _names(phases))
    episodes, warnings = call_in_process("the undisturbed cycle", plan)
    for warning in warnings:
        print_warning(str(warning))
    place = {episode: number for number, episode in enumerate(episodes)}
    results, code = run_tracked("stress", tester, episodes, workers, lost_stress)
    results.sort(key=lambda one: place[one.episode])
    table = StressTable(results, episodes)
    if as_json:
        print_json(warnings, episodes=table.plain())
    else:
        print_table(table)
    if markdown is not None and not code:
        given = {"seeds": seeds, "faults": faults, "phases": phases, "markdown": markdown}
        words = [word for option in given_options(options) for word in option]
        words += [
            word for key, value in given.items() if value for word in (f"--{key}", str(value))
        ]
        command = shlex.join(["bt-manip", "stress", tree, *words])
        _write_page(markdown, table.markdown(command))
    return code or (SUCCESS if all(one.acceptable for one in results) else FAILED)


def _plan(
    make_tester: "Callable[[], StressTester]", *choice: Any
) -> "tuple[list[StressEpisode], Sequence[Any]]":
    from bt_manip_stress import plan_episodes

    tester = make_tester()
    return plan_episodes(tester, *choice), tester.warnings()


def _names(text: str) -> list[str]:
    return [name.strip() for name in text.split(",") if name.strip()]


def print_table(table: "StressTable") -> None:
    """Print the table, the legend and the reasons."""
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    from bt_manip.viewer import print_wrapped
    from bt_manip_stress import LEGEND

    console = Console()
    rows = [["fault", *table.phases], *table.rows()]
    if len(rows[0]) > len(rows):
        rows = [["phase", *table.faults], *map(list, list(zip(*rows, strict=True))[1:])]
    for header, *body in _blocks(rows, console.width):
        drawn = Table(box=box.SIMPLE_HEAD if console.is_terminal else None)
        for column in header:
            drawn.add_column(Text(column), overflow="fold")
        for row in body:
            bad = any(letter in " ".join(row[1:]) for letter in "DHXN")
            drawn.add_row(*map(Text, row), style="red" if bad else "")
        console.print(drawn)
    for line in (table.summary(), LEGEND, *table.reasons()):
        print_wrapped(console, line)


def _blocks(rows: list[list[str]], width: int) -> Iterator[list[list[str]]]:
    """Split a table into tables that are as wide as the screen, each with the first column."""
    widths = [2 + max(map(len, column)) for column in zip(*rows, strict=True)]
    start = 1
    while start < len(widths):
        end = start + 1
        while end < len(widths) and widths[0] + sum(widths[start : end + 1]) <= width:
            end += 1
        yield [[row[0], *row[start:end]] for row in rows]
        start = end


def _write_page(path: Path, text: str) -> None:
    """Write the table to a file, or between the marks of a page."""
    from bt_manip.record import whole_file, writing

    if path.exists():
        before, begin, rest = path.read_text().partition(BEGIN)
        _, end, after = rest.partition(END)
        if begin and end:
            text = f"{before}{BEGIN}\n{text}{END}{after}"
    with writing(path, "table"), whole_file(path) as file:
        file.write(text.encode())
