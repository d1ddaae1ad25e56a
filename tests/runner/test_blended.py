"""The reference task with blended motions: shorter cycles, and bit for bit from any moment."""

from dataclasses import astuple

import numpy as np
import pytest

from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import RunObserver, prepare

from .conftest import request_of_tree

RADIUS = 0.35  # [m]


class Blends(RunObserver):
    """Takes a snapshot after the first tick in each kind of blend."""

    def __init__(self, recorder):
        self.recorder, self.taken = recorder, {}

    def run_started(self, run):
        self.run = run

    def after_tick(self):
        trajectory = self.run.station.arm.trajectory
        if trajectory is not None and trajectory.get_state()["kind"] == "blended":
            key = str(np.round(trajectory.end, 3))
            digest = {"digest": self.run.log.digest.hex()}
            self.taken.setdefault(key, (self.run.get_state(), digest))


def request(parts, cycles, seed=0):
    settings = {"blend_radius": str(RADIUS)}
    return request_of_tree(parts, "pick_place", cycles=cycles, seed=seed, settings=settings)


def report_of(run, *observers):
    recorder = observers[0].recorder if observers else Recorder("", 0)
    run.execute([recorder, *observers])
    return recorder.report()


def check(report):
    assert [cycle.placed for cycle in report.cycles] == [True] * len(report.cycles)
    for cycle in report.cycles:
        assert max(astuple(cycle.limits)) <= 1.0 + 1e-6
        assert cycle.max_tracking_error_rad < 2e-3
        assert not cycle.unexpected_contacts


def test_a_cycle_is_shorter_inside_all_limits_and_continues_bit_for_bit(parts):
    blends = Blends(Recorder("", 0))
    report = report_of(prepare(request(parts, 1), parts), blends)
    check(report)
    assert report.simulated_s <= 3.3
    assert len(blends.taken) == 2
    *_, (run_state, recorder_state) = blends.taken.values()
    again, recorder = prepare(request(parts, 1), parts), Recorder("", 0)
    again.set_state(run_state)
    recorder.set_state(recorder_state)
    again.execute([recorder])
    assert recorder.report().state_digest == report.state_digest


@pytest.mark.soak
@pytest.mark.parametrize("seed", [811, 812])
def test_a_hundred_blended_cycles_are_placed_in_at_most_3_3_s_each_on_average(parts, seed):
    report = report_of(prepare(request(parts, 100, seed), parts))
    check(report)
    assert report.simulated_s / 100 <= 3.3
