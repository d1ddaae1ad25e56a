"""Trajectories: derivatives, ends, limits, and conversion to plain data."""

import json

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.robots import JointLimits
from bt_manip.trajectories import (
    BlendedTrajectory,
    JointTrajectory,
    PathTrajectory,
    SequenceTrajectory,
    SplinePath,
    StraightPath,
    TailTrajectory,
    TimeScaledTrajectory,
    trajectory_from_state,
)
from bt_manip.trajectories.motion_profile import (
    MotionProfile,
    joint_profiles,
    profile_to_position,
    profile_to_velocity,
)

ONE = np.ones(2)
LIMITS = JointLimits(-3 * ONE, 3 * ONE, 2 * ONE, 5 * ONE, 100 * ONE, ONE)
MOVING = (np.array([0.1, -0.2]), np.array([1.5, -0.5]), np.array([2.0, -4.0]))


def joint_trajectory(start=MOVING, target=(1.0, 1.2)):
    limits = LIMITS.velocity, LIMITS.acceleration, LIMITS.jerk
    return JointTrajectory(joint_profiles(start, np.array(target), *limits))


def spline_trajectory():
    s = np.linspace(0.0, 1.0, 15)
    path = SplinePath(np.column_stack([np.sin(2 * s), np.cos(3 * s)]))
    return PathTrajectory(path, profile_to_position((0.0, 0.0, 0.0), 1.0, (0.6, 1.5, 20.0)))


def straight_trajectory():
    profile = profile_to_position((0.0, 0.0, 0.0), 1.0, (1.0, 2.0, 30.0))
    return PathTrajectory(StraightPath(np.zeros(2), np.array([1.0, -0.5])), profile)


def sequence():
    first = straight_trajectory()
    start = (first.end, np.zeros(2), np.zeros(2))
    return SequenceTrajectory([first, joint_trajectory(start, (0.3, 0.4))])


def tail():
    return TailTrajectory(spline_trajectory(), 0.4)


def time_scaled():
    rise = profile_to_velocity((0.0, 0.0, 0.0), 1.2, (3.0, 50.0))
    return TimeScaledTrajectory(straight_trajectory(), rise)


def blended():
    first = straight_trajectory()
    q, v, a = (rows[0] for rows in first.sample(np.array([0.6])))
    return BlendedTrajectory([first, joint_trajectory((q, v, a), (0.3, 0.4))], [0.0, 0.6])


KINDS = [
    joint_trajectory, straight_trajectory, spline_trajectory, sequence, tail, time_scaled, blended
]  # fmt: skip


@pytest.fixture(params=KINDS, ids=lambda make: make.__name__)
def trajectory(request):
    return request.param()


def test_velocity_and_acceleration_are_the_time_derivatives(trajectory):
    h = 1e-5
    middles = np.linspace(0.01, trajectory.duration - 0.01, 97)
    (q0, v0, _), (_, v, a), (q1, v1, _) = (trajectory.sample(middles + d) for d in (-h, 0, h))
    assert np.abs((q1 - q0) / (2 * h) - v).max() < 1e-8 * 100
    inside = np.abs((v1 - v0) / (2 * h) - a)
    assert np.median(inside) < 1e-6 and inside.max() < 100 * h  # the jerk jumps by 100 at most


def test_the_jerk_jumps_at_breakpoints_only(trajectory):
    h = 1e-4
    times = np.arange(0.0, trajectory.duration - h, h)
    jerk = np.diff(trajectory.sample(times)[2], axis=0) / h
    jumps = times[1:-1][(np.abs(np.diff(jerk, axis=0)) > 4.0).any(axis=1)]
    apart = np.abs(jumps[:, np.newaxis] - trajectory.breakpoints()).min(axis=1)
    assert len(jumps) > 1 and apart.max() < 5e-3


def test_it_is_at_rest_exactly_at_its_end(trajectory):
    q, v, a = trajectory.sample(np.array([trajectory.duration, trajectory.duration + 5.0]))
    assert np.array_equal(q, [trajectory.end] * 2)
    assert not v.any() and not a.any()


def test_the_rest_of_a_trajectory_takes_as_much_less_as_it_begins_later():
    whole = spline_trajectory()
    assert tail().duration == pytest.approx(whole.duration - 0.4)
    assert TailTrajectory(whole, whole.duration + 1.0).duration == 0.0


def test_a_time_scaling_that_passes_the_end_of_a_trajectory_ends_there():
    nominal, accelerating = straight_trajectory(), MotionProfile([[0.0, 0.1, 0.5, 0.4, 0.0]], 9, 20)
    scaled = TimeScaledTrajectory(nominal, accelerating)  # s = 0.1 + 0.5 t + 0.2 t^2
    passed = (-0.5 + np.sqrt(0.25 + 0.8 * (nominal.duration - 0.1))) / 0.4
    assert scaled.complete and scaled.duration == pytest.approx(passed)
    assert np.array_equal(scaled.end, nominal.end)


def test_restored_from_plain_data_it_is_the_same_bit_for_bit(trajectory):
    again = trajectory_from_state(json.loads(json.dumps(trajectory.get_state())))
    times = np.linspace(0.0, 1.1 * trajectory.duration, 50)
    for before, after in zip(trajectory.sample(times), again.sample(times), strict=True):
        assert np.array_equal(before, after)


def test_the_active_part_of_a_sequence_moves_as_the_sequence_does():
    both = sequence()
    for t in np.linspace(0.0, both.duration, 31):
        part, time = both.active(t)
        own, whole = (each.sample(np.array([at])) for each, at in ((part, time), (both, t)))
        assert 0.0 <= time <= part.duration + 1e-12
        assert np.array_equal(own, whole)


def test_a_trajectory_of_another_version_is_refused():
    with pytest.raises(MotionError, match="'paced': the snapshot was written by another version"):
        trajectory_from_state({"kind": "paced", "whole": {}, "clock": {}})


def test_a_state_with_the_limits_of_all_coordinates_is_still_read():
    knots = np.column_stack([np.linspace(0.0, 1.0, 8)] * 3)
    profile = profile_to_position((0.0, 0.0, 0.0), 1.0, (1.0, 2.0, 30.0))
    path = SplinePath(knots, 2, np.array([[0.1], [0.2], [0.3]]))
    trajectory = PathTrajectory(path, profile)
    state = json.loads(json.dumps(trajectory.get_state()))
    np.testing.assert_array_equal(trajectory_from_state(state).path.limits, path.limits)
    del state["path"]["limits"]
    state["limits"] = [[1.0, 1.0, limit] for limit in (0.1, 0.2, 0.3)]
    np.testing.assert_array_equal(trajectory_from_state(state).path.limits, path.limits)
