"""Comparison of two success rates on the same episodes."""

import math
from collections.abc import Iterable
from typing import NamedTuple

from .episode import EpisodeResult
from .success import wilson_interval


class PairedTable(NamedTuple):
    """How often each of two, A and B, succeeded in the same episodes.

    Attributes:
        both: Number of episodes in which both succeeded.
        only_a: In which A succeeded and B failed.
        only_b: In which B succeeded and A failed.
        neither: In which both failed.
    """

    both: int
    only_a: int
    only_b: int
    neither: int

    @classmethod
    def of(cls, a: Iterable[EpisodeResult], b: Iterable[EpisodeResult]) -> "PairedTable":
        """Count the episodes that are among both results."""
        first, second = ({one.episode: one.success for one in results} for results in (a, b))
        pairs = [(first[episode], second[episode]) for episode in first if episode in second]
        kinds = ((True, True), (True, False), (False, True), (False, False))
        return cls(*(pairs.count(kind) for kind in kinds))

    @property
    def trials(self) -> int:
        """Number of episodes."""
        return sum(self)

    @property
    def difference(self) -> float:
        """Success rate of B minus that of A."""
        return (self.only_b - self.only_a) / self.trials


def mcnemar_p_value(table: PairedTable) -> float:
    """Return the p-value of McNemar's exact test, two-sided: that both succeed equally often.

    Of the episodes in which they differ, each is as likely won by A as by B (McNemar 1947).
    """
    n, k = table.only_a + table.only_b, min(table.only_a, table.only_b)
    tail = sum(math.comb(n, i) for i in range(k + 1))
    return min(1.0, 2 * tail / 2**n)


def newcombe_interval(table: PairedTable) -> tuple[float, float]:
    """Return the 95 % interval of the difference of two paired rates, B minus A.

    The hybrid score interval (Newcombe 1998, Statistics in Medicine 17: 2635, method 10): Wilson
    intervals of both rates, and the correlation of the pairs, corrected for continuity.
    """
    n = table.trials
    if not n:
        return -1.0, 1.0
    a, b = table.both + table.only_a, table.both + table.only_b
    low_a, high_a = wilson_interval(a, n)
    low_b, high_b = wilson_interval(b, n)
    product = a * (n - a) * b * (n - b)
    phi = 0.0
    if product:
        excess = table.both * table.neither - table.only_a * table.only_b
        phi = (max(excess - n / 2, 0.0) if excess > 0 else excess) / math.sqrt(product)
    down_a, up_a, down_b, up_b = a / n - low_a, high_a - a / n, b / n - low_b, high_b - b / n
    lower = math.sqrt(down_b**2 - 2 * phi * down_b * up_a + up_a**2)
    upper = math.sqrt(up_b**2 - 2 * phi * up_b * down_a + down_a**2)
    return table.difference - lower, table.difference + upper
