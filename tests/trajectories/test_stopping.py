"""Path-consistent stops: they keep path and limits, and are as fast as the limits allow."""

import numpy as np
import pytest

from bt_manip.arm import Arm
from bt_manip.trajectories import (
    JointTrajectory,
    MotionProfile,
    at_speed_scale,
    plan_stop,
    sample_times,
    stopping,
)
from bt_manip.trajectories.limit_check import CONTROL_STEP, has_jump
from bt_manip.trajectories.motion_profile import profile_to_velocity
from bt_manip.trajectories.stop_search import STOP_MARGINS
from tests.measuring.motions import KINDS
from tests.measuring.stops import measure_stops

TURN = np.array([1.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_stops_of_every_kind_of_motion_keep_path_and_limits_within_bounded_counts(monkeypatch):
    checked, ratios, profiles = [], [], stopping.stop_profiles

    def counted(*given):
        for profile in profiles(*given):
            checked.append(profile)
            yield profile

    monkeypatch.setattr(stopping, "stop_profiles", counted)
    for stop in measure_stops(len(KINDS)):
        assert stop.off_path <= 1e-5, stop
        assert stop.limit_use <= 1.0 + 1e-6, stop
        assert stop.duration <= stop.remaining + 1e-9, stop
        ratios.append(stop.ratio)
    assert np.median(ratios) <= 1.02
    assert len(checked) <= len(KINDS) * 2 * len(STOP_MARGINS)


def test_other_joints_go_on_while_one_brakes_at_its_limit(model):
    # Joint 1 cannot brake harder than it does, so no joint slows down before it rests.
    limits, v = model.limits, 1.0
    first = profile_to_velocity((0.0, 1.5, -15.0), 0.0, (15.0, 7500.0))
    second = MotionProfile([[0.0, 0.0, v, 0.0, 0.0]], 2.0, 2.0 * v)
    others = [MotionProfile([], 2.0, q) for q in model.home[2:]]
    motion = JointTrajectory([first, second, *others])
    last = v / limits.acceleration[1] + limits.acceleration[1] / limits.jerk[1]
    stop = plan_stop(motion, 0.0, model)
    assert stop.duration == pytest.approx(first.duration + last, rel=0.03)


@pytest.mark.parametrize("state", [(6.4e-5, 0.048, 24.0), (1e-3, 1.0, 0.0)])
def test_a_motion_that_has_hardly_begun_stops_without_a_jump(arm, state):
    arm.move_to_configuration(arm.model.home + TURN)
    nominal, limits = arm.trajectory, arm.model.limits
    tail = at_speed_scale(nominal, *state[:2])
    stop = stopping.stop_time_scaling(nominal, state, arm.model, tail)
    if stop is not None:
        samples = stop.sample(sample_times(stop.duration, CONTROL_STEP))
        assert not has_jump(samples, limits.jerk)
        assert limits.use(*samples).inside


@pytest.mark.parametrize("share", [0.1, 0.6])
def test_a_stop_never_moves_backwards(robot, ik, share):
    arm = Arm(robot, ik=ik)
    arm.move_to_configuration(arm.model.home + TURN)
    for _ in range(int(share * arm.remaining / 1e-3)):
        arm.advance(1e-3)
    direction = np.sign(arm.v[0])
    arm.stop()
    while arm.moving:
        before = arm.q_ref
        arm.advance(1e-3)
        assert (arm.q - before)[0] * direction >= -1e-12
    assert not arm.v.any() and not arm.a.any()


def test_near_its_end_a_motion_goes_on_to_its_end(arm):
    arm.move_to_configuration(arm.model.home + TURN)
    trajectory = arm.trajectory
    for left in (1e-3, 1.3e-3, 2e-3):
        stop = plan_stop(trajectory, trajectory.duration - left, arm.model)
        assert stop.duration == pytest.approx(left) and np.array_equal(stop.end, trajectory.end)
