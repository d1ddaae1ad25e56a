"""The progress of a run tells how many cycles succeeded and how long the others will take."""

import pytest

from bt_manip.viewer import progress
from bt_manip.viewer.progress import Progress


@pytest.fixture
def clock(monkeypatch):
    now = [0.0]
    monkeypatch.setattr(progress.time, "perf_counter", lambda: now[0])
    return now


@pytest.mark.parametrize(
    ("seconds", "left"), [(1.0, "8 s"), (30.0, "4 min"), (900.0, "2.0 h")]
)  # fmt: skip
def test_the_time_left_is_that_of_the_cycles_so_far(clock, seconds, left):
    shown = Progress(10)
    assert str(shown) == ""
    for cycle, status in enumerate(("SUCCESS", "FAILURE")):
        clock[0] += seconds
        shown.count(cycle, status)
    assert str(shown) == f"1 of 2 cycles succeeded, about {left} left"


def test_without_a_last_cycle_there_is_no_time_left_and_a_continued_run_counts_its_own(clock):
    shown = Progress(0)
    shown.count(0, "SUCCESS")
    assert str(shown) == "1 of 1 cycles succeeded"
    shown = Progress(10)
    clock[0] = 2.0
    shown.count(7, "SUCCESS")
    assert str(shown) == "1 of 1 cycles succeeded, about 4 s left"
