"""The reference task with blended motions: shorter cycles, and bit for bit from any moment."""

from dataclasses import astuple

import numpy as np
import pytest

from bt_manip.record import take_snapshot
from bt_manip.runner import RunObserver, prepare, request_of

from .conftest import continued, report_of

BLENDED = {"blend_radius": "0.35"}  # [m]


class Blends(RunObserver):
    """Takes a snapshot after the first tick in each kind of blend."""

    def run_started(self, run):
        self.run, self.taken = run, {}

    def after_tick(self):
        trajectory = self.run.station.arm.trajectory
        if trajectory is not None and trajectory.get_state()["kind"] == "blended":
            self.taken.setdefault(str(np.round(trajectory.end, 3)), take_snapshot(self.run))


def check(report):
    assert [cycle.placed for cycle in report.cycles] == [True] * len(report.cycles)
    for cycle in report.cycles:
        assert max(astuple(cycle.limits)) <= 1.0 + 1e-6
        assert cycle.max_tracking_error_rad < 2e-3
        assert not cycle.unexpected_contacts


def test_a_cycle_is_shorter_inside_all_limits_and_continues_bit_for_bit(parts):
    blends = Blends()
    report = report_of(parts, "pick_place", blends, settings=BLENDED)
    check(report)
    assert report.simulated_s <= 3.3
    assert len(blends.taken) == 2
    *_, last = blends.taken.values()
    again = prepare(request_of("pick_place", parts, settings=BLENDED), parts)
    assert continued(again, last) == report.state_digest


@pytest.mark.soak
@pytest.mark.parametrize("seed", [811, 812])
def test_a_hundred_blended_cycles_are_placed_in_at_most_3_3_s_each_on_average(parts, seed):
    report = report_of(parts, "pick_place", cycles=100, seed=seed, settings=BLENDED)
    check(report)
    assert report.simulated_s / 100 <= 3.3
