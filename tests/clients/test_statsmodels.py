"""The comparison of two trees agrees with statsmodels."""

import pytest

contingency = pytest.importorskip("statsmodels.stats.contingency_tables", reason="not installed")

from bt_manip.evaluation import PairedTable, mcnemar_p_value  # noqa: E402


@pytest.mark.parametrize(
    "table", [(150, 12, 30, 8), (190, 0, 10, 0), (100, 50, 50, 0), (9, 1, 0, 0)]
)
def test_the_p_value_is_that_of_mcnemar(table):
    both, a, b, neither = table
    expected = contingency.mcnemar([[both, a], [b, neither]], exact=True).pvalue
    assert mcnemar_p_value(PairedTable(*table)) == pytest.approx(expected, rel=1e-9)
