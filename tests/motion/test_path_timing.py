"""A double integrator and a pendulum can be timed by hand; the rest is measured."""

import mujoco
import numpy as np
import pytest

from benchmarks.fastest_drive import fastest_time
from bt_manip.motion import MotionError, PathTrajectory, SplinePath, StraightPath, effort_use
from bt_manip.motion.bounds import Bounds
from bt_manip.motion.driving import drive, drive_straight
from bt_manip.motion.path_timing import time_optimal
from bt_manip.robots import JointLimits, RobotModel

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


def pendulum(gravity=0.0, effort=10.0, acceleration=100.0, velocity=100.0, damping=0.0):
    """A point of 2 kg on a bar of 1 m."""
    one = np.ones(1)
    return RobotModel(
        mujoco.MjModel.from_xml_string(PENDULUM.format(gravity=gravity, damping=damping)),
        joints=["j"],
        tool_frame="tip",
        limits=JointLimits(
            -10 * one, 10 * one, velocity * one, acceleration * one, 1e5 * one, effort * one
        ),
    )


def timed(model, start=0.0, end=1.0):
    path, bounds = StraightPath([start], [end]), Bounds.of_joints(model.limits)
    return PathTrajectory(path, time_optimal(path, bounds, model, 1.0)[0], bounds)


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
    trajectory = drive_straight(np.array([-0.5]), np.array([0.5]), model)
    assert 0.9 < effort_use(trajectory, model, 1e-3) <= 0.9501


def test_where_it_cannot_stand_it_is_refused():
    model = pendulum(gravity=-9.81, effort=19.0)  # 19.62 N m hold the bar level
    with pytest.raises(MotionError, match="joint 1 needs 18.* N m to stand") as raised:
        drive_straight(np.array([-1.0]), np.array([1.0]), model)
    assert raised.value.reason == "effort"


def test_a_curved_path_of_the_panda_is_driven_inside_all_limits_and_close_to_one(model, rng):
    limits, bounds = model.limits, Bounds.of_joints(model.limits)
    for _ in range(5):
        a, b, c = rng.uniform(0.7 * limits.lower, 0.7 * limits.upper, (3, 7))
        s = np.linspace(0.0, 1.0, 15)[:, np.newaxis]
        path = SplinePath(a * (1 - s) ** 2 + 2 * b * s * (1 - s) + c * s**2)
        trajectory = drive(path, bounds, model)
        use, effort = trajectory.use(), effort_use(trajectory, model)
        assert max(use) <= 1.0 and effort <= 0.9501
        # Something binds: a velocity, an acceleration or an effort.
        assert max(use[0], use[1], effort / 0.95) > 0.93


def test_a_tight_corner_does_not_slow_the_rest_of_a_path(model):
    # Two straight ways, and a corner that is rounded within a few of 144 steps.
    pytest.importorskip("toppra")
    first = np.array([2.25, 0.0, 0.75, 0.0, 1.2, 0.0, 0.75]) / 144
    second = np.array([0.0, 1.2, -0.45, 1.2, 0.0, 1.35, -1.2]) / 144
    steps = np.where(np.arange(144)[:, np.newaxis] < 58, first, second)
    window = np.hanning(7) / np.hanning(7).sum()
    steps[3:-3] = [window @ steps[k : k + 7] for k in range(138)]
    path = SplinePath(model.home + np.vstack([np.zeros(7), np.cumsum(steps, axis=0)]))
    driven = drive(path, Bounds.of_joints(model.limits), model)
    assert driven.duration <= 1.1 * fastest_time(driven, model)


def test_at_a_tenth_of_the_speed_a_path_takes_ten_times_the_time(model):
    path = StraightPath(model.home, model.home + 0.4)
    bounds = Bounds.of_joints(model.limits)
    fast, slow = (drive(path, bounds, model, speed).duration for speed in (1.0, 0.1))
    assert slow == pytest.approx(10 * fast, rel=0.02)


def test_where_damping_would_take_all_effort_at_full_speed_it_goes_slower():
    # At 100 rad/s the damping alone asks for 500 N m; with 10 there are 2 rad/s at the most.
    model = pendulum(damping=5.0)
    trajectory = drive_straight(np.zeros(1), np.ones(1), model)
    assert effort_use(trajectory, model) <= 0.95
    assert 0.5 < trajectory.duration < 2.0
