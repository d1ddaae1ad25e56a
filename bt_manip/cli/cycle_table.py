"""The table of cycles that a run ends with."""

from collections.abc import Sequence

from rich import box
from rich.console import Console
from rich.table import Table
from rich.text import Text

from bt_manip.recording import CycleReport, RunReport

_PLACED = {True: "yes", False: "no", None: "-"}


def print_cycles(console: Console, report: RunReport) -> None:
    """Print a line for each cycle and one for the whole run."""
    if report.cycles:
        console.print(_table(report.cycles, lines=console.is_terminal))
        for number, cycle in enumerate(report.cycles, 1):
            if cycle.reason:
                _print(console, f"cycle {number}: {cycle.reason}")
            for pair in cycle.unexpected_contacts:
                _print(console, f"cycle {number}: {pair[0]} touched {pair[1]}")
    _print(console, _summary(report))


def _table(cycles: Sequence[CycleReport], *, lines: bool) -> Table:
    table = Table(box=box.SIMPLE_HEAD if lines else None, pad_edge=lines)
    for title in ("cycle", "status", "object", "placed"):
        table.add_column(title, no_wrap=True)
    for title in ("time [s]", "grip [N]", "error [mrad]", "effort [%]"):
        # Text, because in a string rich would take the unit in [ ] for a style.
        table.add_column(Text(title), no_wrap=True, justify="right")
    for number, cycle in enumerate(cycles, 1):
        style = "" if cycle.status == "SUCCESS" else "red"
        table.add_row(
            str(number),
            cycle.status,
            _handled(cycle),
            _PLACED[cycle.placed],
            f"{cycle.duration_s:.2f}",
            _number(cycle.grip_force_n, "{:.1f}"),
            _number(cycle.max_tracking_error_rad, "{:.2f}", 1e3),
            f"{100 * cycle.limits.effort:.0f}",
            style=style,
        )
    return table


def _handled(cycle: CycleReport) -> str:
    """Name the object of a cycle; with several robots say how many each has picked."""
    if cycle.robots:
        return ", ".join(f"{name} {len(robot.picked)}" for name, robot in cycle.robots.items())
    return cycle.object or "-"


def _summary(report: RunReport) -> str:
    ended = [c for c in report.cycles if c.status in ("SUCCESS", "FAILURE")]
    succeeded = [c for c in ended if c.status == "SUCCESS"]
    line = f"{len(succeeded)} of {len(ended)} cycles succeeded"
    judged = [c.placed for c in ended if c.placed is not None]
    if judged:
        line += f", {sum(judged)} placed"
    if ended:
        line += f", mean {sum(c.duration_s for c in ended) / len(ended):.2f} s"
    line += f"; {report.simulated_s:.1f} s simulated, {report.real_time_factor:.1f} x real time"
    return line


def _number(value: float | None, form: str, scale: float = 1.0) -> str:
    return "-" if value is None else form.format(scale * value)


def _print(console: Console, line: str) -> None:
    console.print(line, markup=False, highlight=False, soft_wrap=True)
