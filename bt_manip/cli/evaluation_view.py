"""Progress and results of an evaluation in the terminal."""

import time
from collections.abc import Iterable, Sequence
from typing import Any

from rich import box
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.table import Table
from rich.text import Text

from bt_manip.cli.cycle_table import value_text
from bt_manip.evaluation import EpisodeResult, Evaluation, Failure, SuccessRate
from bt_manip.exceptions import one_line
from bt_manip.viewer import duration_text

LINE_TIME = 10.0
"""Wall time between two lines where there is no terminal [s]."""

SHOWN_FAILURES = 8
"""Number of failures that are listed, the most frequent ones."""

RECOVERIES = 8
"""Maximum number of listed nodes with retries or rescues; the most frequent come first."""

NARROW = 60
"""Width of a terminal below which rows of tables are lines, in characters."""

MAX_POINTS = 20
"""Number of points of a sweep that are listed while it runs."""


class EvaluationView:
    """A live table in a terminal, or lines elsewhere; `rates` are those of each point."""

    def __init__(
        self, evaluation: Evaluation, episodes: int, workers: int, before: Iterable[EpisodeResult]
    ) -> None:
        self._evaluation, self._workers = evaluation, workers
        self._planned = episodes * len(evaluation.points)
        self.total, self.rates = SuccessRate(), [SuccessRate() for _ in evaluation.points]
        for result in before:
            self._count(result)
        self._before, self._first = self.total.trials, 0.0
        self._simulated, self._printed = 0.0, time.monotonic()
        self._console = Console(stderr=True)
        self._live = Live(
            console=self._console, get_renderable=self._drawn, refresh_per_second=2, transient=True
        )

    def __enter__(self) -> "EvaluationView":
        """Begin to draw."""
        if self._before:
            self._console.print(f"{self._before} episodes are known already.", highlight=False)
        if self._console.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *error: object) -> None:
        """Stop drawing."""
        if self._console.is_terminal:
            self._live.stop()

    def add(self, result: EpisodeResult) -> None:
        """Count a result of this evaluation."""
        now = time.monotonic()
        self._count(result)
        if not self._first:
            self._first = now
        else:
            self._simulated += result.duration_s
        if not self._console.is_terminal and now - self._printed > LINE_TIME:
            self._printed = now
            self._console.print(f"{self._progress()}; {self.total}", highlight=False)

    def point_of(self, failure: Failure) -> dict[str, Any]:
        """Return the values of the varied parameters of the first episode of a failure."""
        for point, rate in enumerate(self.rates):
            if any((f.node, f.first) == (failure.node, failure.first) for f in rate.failures()):
                return dict(self._evaluation.points[point])
        return {}

    def print(self) -> None:
        """Print the results."""
        Console().print(self._results(len(self.rates)))

    def _count(self, result: EpisodeResult) -> None:
        self.total.add(result)
        self.rates[result.point].add(result)

    def _progress(self) -> str:
        done = self.total.trials
        text = f"{done} of {self._planned} episodes, {self._workers} workers"
        elapsed = time.monotonic() - self._first
        counted = done - self._before - 1
        if counted < 1 or elapsed <= 0.0:
            return text
        speed = counted / elapsed
        left = duration_text((self._planned - done) / speed)
        factor = self._simulated / elapsed
        return f"{text}, {speed:.2f} episodes/s ({factor:.2g} x real time), {left} left"

    def _drawn(self) -> RenderableType:
        return Group(Text(self._progress()), self._results(MAX_POINTS))

    def _results(self, points: int) -> RenderableType:
        shown: list[RenderableType] = [Text(str(self.total))]
        shown += map(Text, self.total.use.sentences("episodes"))
        shown += (Text(str(one)) for one in self.total.results())
        if len(self.rates) > 1:
            names = list(self._evaluation.points[0])
            rows = []
            pairs = list(zip(self._evaluation.points, self.rates, strict=True))
            for point, rate in pairs[:points]:
                low, high = rate.interval
                share = f"{rate.successes / rate.trials:.1%}" if rate.trials else ""
                values = [value_text(point[name]) for name in names]
                rows.append((*values, str(rate.trials), share, f"{low:.1%} to {high:.1%}"))
            shown.append(_table((*names, "episodes", "success", "95 % interval"), rows))
        recoveries = self.total.recoveries()
        if recoveries:
            columns = ("retried or rescuing node", "", "times", "episodes", "succeeded")
            rows = [tuple(map(str, recovery)) for recovery in recoveries[:RECOVERIES]]
            shown.append(_table(columns, rows))
            if len(recoveries) > RECOVERIES:
                shown.append(Text(f"{len(recoveries) - RECOVERIES} more are not listed."))
        failures = self.total.failures()
        if failures:
            rows = [
                (one.node or "-", str(one.count), str(one.first), one_line(one.reason))
                for one in failures[:SHOWN_FAILURES]
            ]
            shown.append(_table(("failed node", "episodes", "first", "reason"), rows))
            if len(failures) > SHOWN_FAILURES:
                shown.append(
                    Text(f"{len(failures) - SHOWN_FAILURES} rarer reasons are not listed.")
                )
        return Group(*shown)


def _table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> RenderableType:
    """Return a table, or a line for each row where the terminal is narrow."""
    if Console().width < NARROW:
        lines = (zip(columns, row, strict=True) for row in rows)
        return Group(*(Text("; ".join(f"{c} {v}".strip() for c, v in line)) for line in lines))
    table = Table(box=box.SIMPLE_HEAD)
    for column in columns:
        table.add_column(Text(column), overflow="fold")
    for row in rows:
        table.add_row(*map(Text, row))
    return table
