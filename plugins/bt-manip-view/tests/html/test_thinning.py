"""Thinned lines keep their peaks, thinned time lines their intervals."""

import numpy as np

from bt_manip.record import Interval
from bt_manip_view.html.thinning import merge, thin


def test_peaks_of_a_single_step_survive_with_their_times():
    t = np.arange(60_000) / 1e3
    rows = np.column_stack([t, 1e-4 * np.sin(t), np.full(60_000, np.nan)])
    rows[34_567, 1:], rows[45_678, 1] = (1.0, -2.0), -2.0
    np.testing.assert_array_equal(thin(rows, 60_000), rows)
    kept = thin(rows, 400)
    assert len(kept) <= 400
    assert (np.diff(kept[:, 0]) > 0.0).all()
    times, first, second = kept.T
    assert (first.max(), times[first.argmax()]) == (1.0, t[34_567])
    assert (first.min(), times[first.argmin()]) == (-2.0, t[45_678])
    assert times[second == -2.0] == t[34_567]


def test_intervals_of_one_status_are_joined_until_they_are_few():
    row = [Interval(i / 100, i / 100, "SUCCESS") for i in range(5000)]
    row[2000] = Interval(20.0, 20.0, "FAILURE", "because")
    assert merge([row, []], 5000) == [row, []]
    (merged,) = merge([row], 100)
    assert len(merged) <= 100
    assert (merged[0].start, merged[-1].end) == (0.0, 49.99)
    assert [one for one in merged if one.status == "FAILURE"] == [row[2000]]
    changing = [Interval(i / 100, i / 100, ("SUCCESS", "FAILURE")[i % 2]) for i in range(5000)]
    (merged,) = merge([changing], 100)
    assert len(merged) <= 100
    assert {one.status for one in merged} == {"SUCCESS", "FAILURE"}
