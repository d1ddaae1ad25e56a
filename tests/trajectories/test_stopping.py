"""Path-consistent stops: they keep path and limits, and are as fast as the limits allow."""

import numpy as np
import pytest

from bt_manip.trajectories import (
    BlendedTrajectory,
    JointTrajectory,
    MotionProfile,
    PathTrajectory,
    SequenceTrajectory,
    SplinePath,
    TailTrajectory,
    TimeScaledTrajectory,
    joint_profiles,
    plan_stop,
    stopping,
)
from bt_manip.trajectories.motion_profile import profile_to_position, profile_to_velocity
from bt_manip.trajectories.stop_search import STOP_MARGINS
from tests.measuring.motions import KINDS
from tests.measuring.stops import measure_stops

from .pendulum import pendulum

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
    assert np.median(ratios) <= 1.007
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
    assert stop.duration == pytest.approx(first.duration + last, rel=0.005)


def test_near_its_end_a_motion_goes_on_to_its_end(arm):
    arm.move_to_configuration(arm.model.home + TURN)
    trajectory = arm.trajectory
    for left in (1e-3, 1.3e-3, 2e-3):
        stop = plan_stop(trajectory, trajectory.duration - left, arm.model)
        assert stop.duration == pytest.approx(left) and np.array_equal(stop.end, trajectory.end)


def test_a_stop_begins_in_the_state_of_motion_that_it_ends():
    model = pendulum(effort=1e4, acceleration=20.0, jerk=2000.0, velocity=10.0)
    s, limits = (
        np.linspace(0.0, 1.0, 9),
        (model.limits.velocity, 5.0 * np.ones(1), 100 * np.ones(1)),
    )
    curve = SplinePath((0.4 * s + 0.6 * s**2)[:, np.newaxis])
    along = PathTrajectory(curve, profile_to_position((0.0, 0.0, 0.0), 1.0, (0.6, 1.5, 20.0)))
    scaled = TimeScaledTrajectory(along, profile_to_velocity((0.5, 0.4, 0.5), 0.9, (0.6, 3.0)))
    state = tuple(rows[0] for rows in along.sample(np.array([0.8])))
    after, back = (
        JointTrajectory(joint_profiles(begin, np.array([0.2]), *limits))
        for begin in (state, (along.end, np.zeros(1), np.zeros(1)))
    )
    blended = BlendedTrajectory([along, after], [0.0, 0.8])
    for trajectory, t in (
        (along, 0.7),
        (scaled, 0.6),
        (TailTrajectory(scaled, 0.2), 0.35),
        (blended, 0.3),
        (TailTrajectory(blended, 0.5), 0.5),
        (SequenceTrajectory([along, back]), 2.6),
    ):
        stop = plan_stop(trajectory, t, model)
        assert 0.01 < stop.duration < 0.6 * (trajectory.duration - t)
        for begins, ends in zip(
            stop.sample(np.zeros(1)), trajectory.sample(np.array([t])), strict=True
        ):
            assert begins == pytest.approx(ends, rel=1e-9) and abs(begins[0]) > 0.01
