"""Two success rates on the same episodes are compared by exact and published methods."""

import numpy as np
import pytest
from scipy.stats import binomtest

from bt_manip.evaluation import EpisodeResult, PairedTable, mcnemar_p_value, newcombe_interval


def results(*successes):
    return [EpisodeResult(0, i, 0, bool(one), "") for i, one in enumerate(successes)]


def test_episodes_are_paired_by_their_numbers():
    table = PairedTable.of(results(1, 1, 0, 0, 1), reversed(results(1, 0, 1, 0)))
    assert table == (1, 1, 1, 1) and table.trials == 4 and table.difference == 0.0


@pytest.mark.parametrize(
    ("table", "low", "high"),
    [  # Newcombe (1998), Statistics in Medicine 17: 2635, table II, method 10; B has more successes
        ((36, 2, 12, 0), 0.0569, 0.3404),
        ((54, 0, 0, 0), -0.0664, 0.0664),
        ((0, 0, 0, 0), -1.0, 1.0),  # nothing is known
    ],
)
def test_the_interval_of_the_difference_is_newcombes(table, low, high):
    assert newcombe_interval(PairedTable(*table)) == pytest.approx((low, high), abs=5e-5)
    both, a, b, neither = table
    swapped = newcombe_interval(PairedTable(both, b, a, neither))
    assert swapped == pytest.approx((-high, -low), abs=5e-5)


@pytest.mark.parametrize("counts", [(8, 3, 2, 7), (9, 4, 3, 2), (5, 6, 8, 1), (9, 4, 0, 0)])
def test_the_interval_is_of_wilsons_with_the_corrected_correlation_of_the_pairs(counts):
    pairs = np.repeat([[1, 1], [1, 0], [0, 1], [0, 0]], counts, axis=0)
    (both, only_a, only_b, neither), n = counts, len(pairs)
    excess = both * neither - only_a * only_b
    corrected = max(excess - n / 2, 0) / excess if excess > 0 else 1
    rates, spread = pairs.mean(axis=0), pairs.std(axis=0).prod()
    phi = corrected * np.cov(pairs.T, ddof=0)[0, 1] / spread if spread else 0.0
    tests = (binomtest(int(one), n).proportion_ci(0.95, "wilson") for one in pairs.sum(axis=0))
    a, b = (np.array(one) - rate for one, rate in zip(tests, rates, strict=True))
    found = newcombe_interval(PairedTable(*counts))
    for i, sign in ((0, -1), (1, 1)):
        half = np.sqrt(b[i] ** 2 + a[1 - i] ** 2 + 2 * phi * b[i] * a[1 - i])
        assert found[i] == pytest.approx(rates[1] - rates[0] + sign * half, abs=1e-12)


@pytest.mark.parametrize(("a", "b"), [(0, 0), (0, 9), (7, 7), (14, 33), (28, 0), (21, 198)])
def test_the_test_is_the_exact_binomial_one(a, b):
    expected = binomtest(a, a + b).pvalue if a + b else 1.0
    assert mcnemar_p_value(PairedTable(50, a, b, 3)) == pytest.approx(expected, rel=1e-9)
