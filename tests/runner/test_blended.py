"""The reference task with blended motions: shorter cycles, and bit for bit from any moment."""

from dataclasses import astuple

import numpy as np
import pytest

from bt_manip.record import take_snapshot
from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import RunObserver, prepare, request_of

from .conftest import continued

RADIUS = 0.35  # [m]


class Blends(RunObserver):
    """Takes a snapshot after the first tick in each kind of blend."""

    def run_started(self, run):
        self.run, self.taken = run, {}

    def after_tick(self):
        trajectory = self.run.station.arm.trajectory
        if trajectory is not None and trajectory.get_state()["kind"] == "blended":
            self.taken.setdefault(str(np.round(trajectory.end, 3)), take_snapshot(self.run))


def request(parts, cycles, seed=0):
    settings = {"blend_radius": str(RADIUS)}
    return request_of("pick_place", parts, cycles=cycles, seed=seed, settings=settings)


def report_of(run, *observers):
    recorder = Recorder("", 0)
    run.execute([recorder, *observers])
    return recorder.report()


def check(report):
    assert [cycle.placed for cycle in report.cycles] == [True] * len(report.cycles)
    for cycle in report.cycles:
        assert max(astuple(cycle.limits)) <= 1.0 + 1e-6
        assert cycle.max_tracking_error_rad < 2e-3
        assert not cycle.unexpected_contacts


def test_a_cycle_is_shorter_inside_all_limits_and_continues_bit_for_bit(parts):
    blends = Blends()
    report = report_of(prepare(request(parts, 1), parts), blends)
    check(report)
    assert report.simulated_s <= 3.3
    assert len(blends.taken) == 2
    *_, last = blends.taken.values()
    assert continued(prepare(request(parts, 1), parts), last) == report.state_digest


@pytest.mark.soak
@pytest.mark.parametrize("seed", [811, 812])
def test_a_hundred_blended_cycles_are_placed_in_at_most_3_3_s_each_on_average(parts, seed):
    report = report_of(prepare(request(parts, 100, seed), parts))
    check(report)
    assert report.simulated_s / 100 <= 3.3
