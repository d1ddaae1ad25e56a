"""Results of a run in the terminal: table of cycles, summary and next step."""

import math
import shlex
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from rich import box
from rich.console import Console, Group, RenderableType
from rich.table import Table
from rich.text import Text

from bt_manip.cli.record_option import record_target
from bt_manip.cli.run_options import RunOptions
from bt_manip.record import CycleReport, LeafUse, RunReport, TrackingPeak
from bt_manip.viewer import print_wrapped

_MET = {True: "yes", False: "no", None: "-"}


class _Column(NamedTuple):
    title: str
    text: Callable[[CycleReport], str]
    is_number: bool = True


_COLUMNS = (
    _Column("status", lambda cycle: cycle.status, is_number=False),
    _Column("object", lambda cycle: _handled(cycle), is_number=False),
    _Column("goal\nmet", lambda cycle: _MET[cycle.goal], is_number=False),
    _Column("time\n[s]", lambda cycle: f"{cycle.duration_s:.2f}"),
    _Column("grip\n[N]", lambda cycle: _number(cycle.grip_force_n, "{:.1f}")),
    _Column("error\n[mrad]", lambda cycle: _number(cycle.max_tracking_error_rad, "{:.2f}", 1e3)),
    _Column("effort\n[%]", lambda cycle: _percent(cycle.limits.effort)),
)
"""Columns beside the number of the cycle; in narrow terminals the last ones are left out."""

TRACKING_ERROR = 2e-3
"""Tracking error in free motion above which it is printed, with its likely cause [rad]."""

SATURATED = 0.999
"""Use of an effort limit from which a motor counts as saturated."""

DEFLECTION = 0.02
"""Deflection of a joint by contact above which it is printed [rad]."""

_FEWEST = 4
"""Number of these columns that are never left out; the names of objects are wrapped instead."""


def print_cycles(console: Console, report: RunReport) -> None:
    """Print a row for each cycle and a sentence on the run, all within the console's width."""
    if report.cycles:
        console.print(_fitting_table(console, report.cycles))
        for number, cycle in enumerate(report.cycles, 1):
            if cycle.reason:
                print_wrapped(console, f"cycle {number}: {cycle.reason}")
            if cycle.goal_reason not in cycle.reason:
                print_wrapped(console, f"cycle {number}: goal not met: {cycle.goal_reason}")
            for pair in cycle.unexpected_contacts:
                print_wrapped(console, f"cycle {number}: {pair[0]} touched {pair[1]}")
        number, worst = max(
            enumerate(report.cycles, 1), key=lambda one: one[1].max_tracking_error_rad or 0.0
        )
        error, peak = worst.max_tracking_error_rad or 0.0, worst.tracking_peak
        if peak is not None and error > TRACKING_ERROR:
            print_wrapped(console, _tracking(error, peak, number))
        largest = max(cycle.max_deflection_rad for cycle in report.cycles)
        if largest > DEFLECTION:
            print_wrapped(
                console, f"At rest or in contact, joints gave way by {1e3 * largest:.0f} mrad."
            )
    use = LeafUse()
    for cycle in report.cycles:
        use.add(cycle.leaf_times, cycle.duration_s)
    for line in use.sentences("cycles"):
        print_wrapped(console, line)
    print_wrapped(console, summary(report))


def next_step(options: RunOptions, report: RunReport, *, is_terminal: bool = False) -> str:
    """Return a line that says what to do next, or an empty text.

    Args:
        options: The options of the run.
        report: Its report.
        is_terminal: Whether the line is printed to a terminal.
    """
    files = [record_target(text)[1] for text in options.records]
    recordings = [file for file in files if file.endswith(".mcap") and Path(file).exists()]
    if recordings:
        file = shlex.quote(recordings[0])
        return f"To watch the recording: bt-manip replay {file}, or bt-manip report {file}"
    if report.status == "FAILURE" and not files:
        view = "" if "view" in options.views else " --view"
        return f"To watch the failure: the same command with --record run.mcap{view}"
    untried = {
        "--window": not options.window,
        "--view": "view" not in options.views,
        "--cycles 10": options.cycles == 1,
        "--real-time 1": options.real_time is None and not (options.window or options.views),
    }
    wanted = ", ".join(option for option, is_new in untried.items() if is_new)
    if wanted and report.status == "SUCCESS" and is_terminal:
        return f"Options to try next: {wanted}"
    return ""


def _percent(part: float) -> str:
    """Return a fraction in percent; a hyphen for one that is not known."""
    return "-" if math.isnan(part) else f"{100 * part:.0f}"


def _tracking(error: float, peak: TrackingPeak, cycle: int) -> str:
    """Return a sentence on the largest tracking error [rad] and its likely cause."""
    text = (
        f"In free motion, joints were up to {1e3 * error:.1f} mrad from their reference: "
        f"'{peak.joint}' in {peak.leaf or 'no leaf'}, {peak.time_s:.2f} s into cycle {cycle}"
    )
    if peak.effort >= SATURATED:
        return f"{text}, when a motor was at its effort limit."
    if peak.after_contact_s is not None:
        return f"{text}, {1e3 * peak.after_contact_s:.0f} ms after a contact ended."
    return (
        f"{text}, without contact and with motors at up to {_percent(peak.effort)} % of their "
        "limits: friction, little rotor inertia, or a controller without a model of the dynamics."
    )


def summary(report: RunReport) -> str:
    """Return a sentence on how the cycles of a run ended."""
    ended = [c for c in report.cycles if c.status in ("SUCCESS", "FAILURE")]
    how = {"INTERRUPTED": "was interrupted", "ERROR": "ended by a fault"}.get(report.status, "")
    simulated = f"{report.simulated_s:.1f} s simulated"
    if not ended:
        return f"The run {how or 'ended'} before a cycle was complete, after {simulated}."
    succeeded = sum(c.status == "SUCCESS" for c in ended)
    line = f"{succeeded} of {len(ended)} cycles succeeded"
    if any(cycle.goal is not None for cycle in ended):
        line += f", goal met in {sum(cycle.goal is True for cycle in ended)}"
    if len(ended) > 1:
        line += f", {sum(c.duration_s for c in ended) / len(ended):.2f} s each"
    if how:
        line += f"; then the run {how}"
    return f"{line}; {simulated} at {report.real_time_factor:.1f} x real time."


def _fitting_table(console: Console, cycles: Sequence[CycleReport]) -> RenderableType:
    """Return the table with as many columns as fit; those of results are never left out.

    In a terminal that is too narrow for these, the result is a line for each cycle.
    """
    keys = dict.fromkeys(key for cycle in cycles for key in cycle.results)
    columns = (*_COLUMNS[:_FEWEST], *map(_result_column, keys), *_COLUMNS[_FEWEST:])
    fewest = _FEWEST + len(keys)
    for count in range(len(columns), fewest, -1):
        table = _table(cycles, columns[:count], lines=console.is_terminal)
        if console.measure(table).maximum < console.width:
            return table
    wide = console.options.update(width=10 * console.width)
    for lines in (console.is_terminal, False):
        table = _table(cycles, columns[:fewest], lines=lines)
        if console.measure(table, options=wide).minimum <= console.width:
            return table
    titles = [column.title.replace("\n", " ") for column in columns[:fewest]]
    rows = (
        ", ".join(f"{t} {c.text(cycle)}" for t, c in zip(titles, columns, strict=False))
        for cycle in cycles
    )
    return Group(*(Text(f"cycle {number}: {row}") for number, row in enumerate(rows, 1)))


def _result_column(key: str) -> _Column:
    return _Column(key, lambda cycle: value_text(cycle.results.get(key)))


def value_text(value: Any) -> str:
    """Return a value of a result or parameter; '-' for None."""
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _table(cycles: Sequence[CycleReport], columns: Sequence[_Column], *, lines: bool) -> Table:
    table = Table(box=box.SIMPLE_HEAD if lines else None, pad_edge=lines)
    table.add_column("cycle", no_wrap=True)
    for column in columns:
        table.add_column(
            Text(column.title),  # in a string, rich would take the unit in [ ] for a style
            justify="right" if column.is_number else "left",
            no_wrap=column.title != "object",
            overflow="fold",
        )
    for number, cycle in enumerate(cycles, 1):
        table.add_row(
            str(number),
            *(column.text(cycle) for column in columns),
            style="" if cycle.status == "SUCCESS" else "red",
        )
    return table


def _handled(cycle: CycleReport) -> str:
    """Name the object of a cycle; with several robots say how many each has picked."""
    if cycle.robots:
        return ", ".join(f"{name} {len(robot.picked)}" for name, robot in cycle.robots.items())
    return ", ".join(one.name for one in cycle.objects) or "-"


def _number(value: float | None, form: str, scale: float = 1.0) -> str:
    return "-" if value is None else form.format(scale * value)
