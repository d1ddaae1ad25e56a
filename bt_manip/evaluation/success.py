"""Success rates, their intervals, and the reasons of failures."""

import json
import math
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import NamedTuple

from bt_manip.exceptions import without_numbers
from bt_manip.record import LeafTime, LeafUse

from .episode import NO_OUTCOME, EpisodeResult

Z95 = 1.959963984540054
"""Quantile of the normal distribution for intervals of 95 %."""


class Interval95(NamedTuple):
    """A confidence interval of 95 % of a probability."""

    low: float
    high: float

    @property
    def width(self) -> float:
        """Difference of the bounds."""
        return self.high - self.low


def wilson_interval(successes: int, trials: int) -> Interval95:
    """Return the Wilson score interval of a success rate (Wilson 1927); 0 to 1 without trials."""
    if not trials:
        return Interval95(0.0, 1.0)
    rate, z2 = successes / trials, Z95**2 / trials
    centre = (rate + z2 / 2) / (1 + z2)
    half = math.sqrt(z2 * rate * (1 - rate) + z2**2 / 4) / (1 + z2)
    return Interval95(max(0.0, centre - half), min(1.0, centre + half))


def _mean(values: list[float]) -> tuple[float, float, int]:
    """Return mean, half of its confidence interval, and number of values."""
    count, mean = len(values), math.fsum(values) / len(values)
    squares = math.fsum((value - mean) ** 2 for value in values)
    half = Z95 * math.sqrt(squares / (count - 1) / count) if count > 1 else math.nan
    return mean, half, count


@dataclass(frozen=True)
class Failure:
    """Failures of the same node with the same reason, numbers apart.

    Attributes:
        node: Path of the node.
        reason: The reason of the first of them.
        first: Number of the first of these episodes.
        count: Number of episodes.
    """

    node: str
    reason: str
    first: int
    count: int


class Recovery(NamedTuple):
    """How often a node was retried, or a fallback rescued the tree.

    Attributes:
        node: Path of the `RetryUntilSuccessful` or the fallback.
        kind: ``"retries"`` or ``"rescues"``.
        total: Number of them in all episodes.
        episodes: Number of episodes with any.
        successes: Number of these that succeeded.
    """

    node: str
    kind: str
    total: int
    episodes: int
    successes: int


class MeanResult(NamedTuple):
    """Mean of a result of a tree over episodes.

    Attributes:
        key: Key of the result.
        mean: The mean.
        half_width: Half of the confidence interval of 95 % of the mean, by the normal
            approximation; NaN for a single episode.
        episodes: Number of episodes in which it was a number.
    """

    key: str
    mean: float
    half_width: float
    episodes: int

    def __str__(self) -> str:
        """Return key, mean and interval."""
        low, high = self.mean - self.half_width, self.mean + self.half_width
        interval = "" if math.isnan(low) else f" (95 %: {low:.3g} to {high:.3g})"
        return f"{self.key}: {self.mean:.3g} on average{interval}, in {self.episodes} episodes"


@dataclass
class SuccessRate:
    """Counts successes and failures of episodes.

    Attributes:
        trials: Number of episodes.
        successes: How many of them succeeded.
        no_outcome: How many of them did not begin, or ended with their process.
        use: Leaves that declare `reports_time`.
    """

    trials: int = 0
    successes: int = 0
    no_outcome: int = 0
    use: LeafUse = field(default_factory=LeafUse)
    _results: dict[str, list[float]] = field(default_factory=dict)
    _recoveries: dict[tuple[str, str], Recovery] = field(default_factory=dict)
    _first: dict[tuple[str, str], tuple[str, int]] = field(default_factory=dict)
    _counts: Counter[tuple[str, str]] = field(default_factory=Counter)

    @classmethod
    def of(cls, results: Iterable[EpisodeResult]) -> "SuccessRate":
        """Count some results."""
        rate = cls()
        for result in results:
            rate.add(result)
        return rate

    def add(self, result: EpisodeResult) -> None:
        """Count a result."""
        self.trials += 1
        self.successes += result.success
        self.no_outcome += result.status in NO_OUTCOME
        times = json.loads(result.leaf_times)
        self.use.add({name: LeafTime(**one) for name, one in times.items()}, result.duration_s)
        for key, value in json.loads(result.results).items():
            if isinstance(value, int | float):
                self._results.setdefault(key, []).append(float(value))
        for kind in ("retries", "rescues"):
            for node, count in json.loads(getattr(result, kind)).items():
                old = self._recoveries.get((node, kind), Recovery(node, kind, 0, 0, 0))
                total, episodes = old.total + count, old.episodes + 1
                successes = old.successes + result.success
                self._recoveries[node, kind] = Recovery(node, kind, total, episodes, successes)
        if not result.success:
            key = result.node, without_numbers(result.reason)
            known = self._first.setdefault(key, (result.reason, result.episode))
            if result.episode < known[1]:
                self._first[key] = result.reason, result.episode
            self._counts[key] += 1

    @property
    def interval(self) -> Interval95:
        """The Wilson interval of the success rate."""
        return wilson_interval(self.successes, self.trials)

    def results(self) -> list[MeanResult]:
        """Return the means of the tree's results that are numbers."""
        return [MeanResult(key, *_mean(values)) for key, values in self._results.items()]

    def recoveries(self) -> list[Recovery]:
        """Return retries and rescues by node, those in most episodes first."""
        return sorted(self._recoveries.values(), key=lambda one: (-one.episodes, one.node))

    def failures(self) -> list[Failure]:
        """Return the failures by node and reason, the most frequent first."""
        found = [Failure(key[0], *self._first[key], count) for key, count in self._counts.items()]
        return sorted(found, key=lambda one: (-one.count, one.first))

    def __str__(self) -> str:
        """Return the rate with its interval."""
        if not self.trials:
            return "no episodes"
        low, high = self.interval
        share = self.successes / self.trials
        return (
            f"{self.successes} of {self.trials} episodes succeeded: {share:.2%} "
            f"(95 %: {low:.2%} to {high:.2%})"
            + (f", {self.no_outcome} had no outcome" if self.no_outcome else "")
        )
