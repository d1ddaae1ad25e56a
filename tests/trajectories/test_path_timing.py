"""A double integrator and a pendulum can be timed by hand; the rest is measured."""

import mujoco
import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.robots import JointLimits, RobotModel
from bt_manip.trajectories import PathTrajectory, SplinePath, StraightPath, effort_use
from bt_manip.trajectories.kinematic_limits import KinematicLimits
from bt_manip.trajectories.path_timing import PathTiming
from bt_manip.trajectories.reachability import greatest_squares
from bt_manip.trajectories.time_parameterization import time_parameterize, time_parameterize_segment
from tests.measuring.fastest_drive import fastest_time

PENDULUM = """
<mujoco>
  <option gravity="0 0 {gravity}"/>
  <worldbody>
    <body>
      <joint name="j" axis="0 1 0" damping="{damping}"/>
      <inertial pos="1 0 0" mass="2" diaginertia="1e-9 1e-9 1e-9"/>
      <site name="tip" pos="1 0 0"/>
    </body>
  </worldbody>
</mujoco>
"""


def pendulum(gravity=0.0, effort=10.0, acceleration=100.0, velocity=100.0, damping=0.0, jerk=1e5):
    """A point of 2 kg on a bar of 1 m."""
    one = np.ones(1)
    return RobotModel(
        mujoco.MjModel.from_xml_string(PENDULUM.format(gravity=gravity, damping=damping)),
        joints=["j"],
        tool_frame="tip",
        limits=JointLimits(
            -10 * one, 10 * one, velocity * one, acceleration * one, jerk * one, effort * one
        ),
    )


def timed(model, start=0.0, end=1.0):
    path, bounds = StraightPath([start], [end]), KinematicLimits.of_joints(model.limits)
    timing = PathTiming(path, bounds, model, 1.0, 120)
    return PathTrajectory(path, timing.plan(timing.nodes[0]), bounds)


def test_with_an_acceleration_limit_alone_it_takes_the_time_of_the_textbook():
    # Half the way at a, half at -a: 2 sqrt(d / a).
    duration = timed(pendulum(effort=1e4, acceleration=4.0), end=1.5).duration
    assert duration == pytest.approx(2 * np.sqrt(1.5 / 4.0), rel=0.03)


def test_with_an_effort_limit_alone_it_takes_the_time_of_the_textbook():
    # 10 N m turn 2 kg m2 by 5 rad/s2.
    assert timed(pendulum(effort=10.0), end=1.5).duration == pytest.approx(
        2 * np.sqrt(1.5 / 5.0), rel=0.03
    )


def test_with_a_velocity_limit_it_cruises():
    # d / v + v / a.
    duration = timed(pendulum(effort=1e4, acceleration=4.0, velocity=1.0), end=3.0).duration
    assert duration == pytest.approx(3.0 / 1.0 + 1.0 / 4.0, rel=0.03)


def test_with_gravity_it_uses_what_gravity_leaves():
    model = pendulum(gravity=-9.81, effort=25.0)
    trajectory = time_parameterize_segment(np.array([-0.5]), np.array([0.5]), model)
    assert 0.9 < effort_use(trajectory, model, 1e-3) <= 0.9501


def test_where_it_cannot_stand_it_is_refused():
    model = pendulum(gravity=-9.81, effort=19.0)  # 19.62 N m hold the bar level
    with pytest.raises(MotionError, match="joint 1 needs 18.* N m to stand") as raised:
        time_parameterize_segment(np.array([-1.0]), np.array([1.0]), model)
    assert raised.value.reason == "effort"


def test_with_scarce_jerk_and_effort_it_is_nearly_as_fast_as_both_allow():
    # 32 N m turn 2 kg m2 by 16 rad/s2, which take r = 16 / 500 s to come and to go: half the way is
    # a (t - r) t / 2 in the time t. A plan that has to be slowed for its jerk asks for less effort.
    model = pendulum(effort=32.0 / 0.95, acceleration=20.0, jerk=500.0)
    path = StraightPath(np.zeros(1), 5.0 * np.ones(1))
    duration = time_parameterize(path, KinematicLimits.of_joints(model.limits), model).duration
    a, r = 16.0, 16.0 / 500.0
    optimum = r + np.sqrt(r**2 + 4 * 5.0 / a)
    assert optimum < duration < 1.05 * optimum


def test_what_a_load_adds_between_two_looks_is_not_beyond_the_limits():
    # 5.1 rad in 120 steps: in each, gravity changes by up to 0.8 N m, 3 % of the effort.
    model = pendulum(gravity=-9.81, effort=25.0, acceleration=20.0)
    path, bounds = StraightPath([-5.0], [0.1]), KinematicLimits.of_joints(model.limits)
    timing = PathTiming(path, bounds, model, 0.95, 120)
    plan = PathTrajectory(path, timing.plan(timing.nodes[0]), bounds)
    assert effort_use(plan, model, 1e-3) <= 0.951


def bent(model, sharpness):
    """Two straight ways, and a corner that is rounded within a few of 144 steps."""
    first = np.array([2.25, 0.0, 0.75, 0.0, 1.2, 0.0, 0.75]) / 144
    second = np.array([0.0, 1.2, -0.45, 1.2, 0.0, 1.35, -1.2]) / 144
    steps = np.where(np.arange(144)[:, np.newaxis] < 58, first, second)
    window = np.hanning(sharpness) / np.hanning(sharpness).sum()
    half = sharpness // 2
    steps[half:-half] = [window @ steps[k : k + sharpness] for k in range(145 - sharpness)]
    return SplinePath(model.home + np.vstack([np.zeros(7), np.cumsum(steps, axis=0)]))


def test_a_plan_keeps_off_the_limits_where_the_last_one_was_beyond_them_and_only_there(model):
    path, bounds = bent(model, 5), KinematicLimits.of_joints(model.limits)
    timing = PathTiming(path, bounds, None, 1.0, 120)
    node = timing.nodes[0]
    plan = timing.plan(node)
    again = timing.keeping_off(plan).plan(node)
    first, second = (
        PathTrajectory(path, profile, bounds).kinematic_use()[1] for profile in (plan, again)
    )
    assert first > 1.5 and second < 1.2
    assert again.duration < 1.05 * plan.duration
    behind = np.linspace(0.6, 0.98, 30)  # the corner is at 0.4
    speeds = (
        np.interp(behind, *profile.sample(np.arange(0.0, profile.duration, 1e-3))[:2])
        for profile in (again, plan)
    )
    assert np.allclose(*speeds, rtol=0.01)


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_bend_within_one_step_makes_a_path_slow_there_and_nowhere_come_to_rest(side):
    # A joint that hardly moves, limits of 1 on either side, bends at one of 121 points.
    rates, squares = np.tile([1.0, 1e-2], (121, 1)), np.zeros((121, 2))
    squares[60, 1] = 50.0 * side
    limits, most = np.ones((121, 2)), np.full(121, 0.5)
    z = greatest_squares(rates, squares, limits, limits, most)
    straight = greatest_squares(rates, np.zeros((121, 2)), limits, limits, most)
    assert 0.9 / 50.0 < z[60] < 1.1 / 50.0
    assert z[1:-1].min() > 0.4 * z[60]
    # It speeds up and brakes by 2 u h = 1 / 60 in each step: 29 of them lead from 0.02 to 0.5.
    assert z[:30] == pytest.approx(straight[:30]) and z[91:] == pytest.approx(straight[91:])


def test_a_curved_path_of_the_panda_is_driven_inside_all_limits_and_close_to_one(model, rng):
    limits, bounds = model.limits, KinematicLimits.of_joints(model.limits)
    for _ in range(5):
        a, b, c = rng.uniform(0.7 * limits.lower, 0.7 * limits.upper, (3, 7))
        s = np.linspace(0.0, 1.0, 15)[:, np.newaxis]
        path = SplinePath(a * (1 - s) ** 2 + 2 * b * s * (1 - s) + c * s**2)
        trajectory = time_parameterize(path, bounds, model)
        use, effort = trajectory.kinematic_use(), effort_use(trajectory, model)
        assert max(use) <= 1.0 and effort <= 0.9501
        # Something binds: a velocity, an acceleration or an effort.
        assert max(use[0], use[1], effort / 0.95) > 0.93


@pytest.mark.parametrize(("jerk", "longer"), [(1.0, 1.06), (0.05, 1.12)])
def test_a_tight_corner_does_not_slow_the_rest_of_a_path(model, jerk, longer):
    pytest.importorskip("toppra")
    bounds = KinematicLimits.of_joints(model.limits)._replace(jerk=jerk * model.limits.jerk)
    driven = time_parameterize(bent(model, 5), bounds, model)
    assert max(driven.kinematic_use()) <= 1.0
    assert driven.duration <= longer * fastest_time(driven, model)


def test_at_a_tenth_of_the_speed_a_path_takes_ten_times_the_time(model):
    path = StraightPath(model.home, model.home + 0.4)
    bounds = KinematicLimits.of_joints(model.limits)
    fast, slow = (time_parameterize(path, bounds, model, speed).duration for speed in (1.0, 0.1))
    assert slow == pytest.approx(10 * fast, rel=0.02)


def test_where_damping_would_take_all_effort_at_full_speed_it_goes_slower():
    # At 100 rad/s the damping alone asks for 500 N m; with 10 there are 2 rad/s at the most.
    model = pendulum(damping=5.0)
    trajectory = time_parameterize_segment(np.zeros(1), np.ones(1), model)
    assert effort_use(trajectory, model) <= 0.95
    assert 0.5 < trajectory.duration < 2.0
