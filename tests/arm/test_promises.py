"""What all motions promise, of any arm, from any start and with any requests.

They are judged by their positions at control steps alone: by the differences of these, and by
MuJoCo's positions of the tool.
"""

from functools import cache
from math import inf

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from bt_manip.robots import Robot, compile_alone, panda
from tests.measuring.random_arms import random_arm
from tests.measuring.requests import REQUESTS, STEP, Trial
from tests.robot_fixtures import MENAGERIE_ARMS, menagerie_robot

POSITION = 1e-6  # [rad] or [m] beside a limit of position
VELOCITY, ACCELERATION, JERK = 1e-4, 5e-3, 5e-3  # parts by which differences exceed the limits
EFFORT = 0.9501  # of the effort limits
OUTSIDE = 1e-3  # [m] of the tool outside its box
OFF_PATH = 2e-5  # [rad] between two control steps of the path
AT_GOAL = 1e-4  # [m] and [rad]

TRIALS = {
    "seed": st.integers(0, 2**32 - 1),
    "requests": st.lists(
        st.tuples(st.sampled_from(REQUESTS), st.floats(0.0, 1.0)), min_size=1, max_size=5
    ),
    "tool_speed": st.sampled_from([inf, 0.1, 0.25, 1.0]),
    "boxed": st.booleans(),
}
FAST = settings(max_examples=4, deadline=None, derandomize=True)
LONG = settings(max_examples=500, deadline=None)


@cache
def robot_named(name: str, menagerie: str) -> Robot:
    """Return a compiled robot."""
    if name != "panda":
        return menagerie_robot(menagerie, name, 0.1, acceleration=6.0, jerk=3000.0, effort=400.0)
    robot = Robot(panda())
    compile_alone(robot)
    return robot


def check(robot, seed, requests, tool_speed, boxed):
    """Make requests to an arm, and check what it did."""
    trial = Trial(robot, seed, tool_speed, boxed)
    trial.request("turn", 0.0)
    for kind, share in requests:
        trial.request(kind, share)
    trial.finish()
    check_limits(trial, tool_speed)
    assert trial.off_path <= OFF_PATH
    check_goal(trial)
    return trial


def check_limits(trial, tool_speed):
    description, robot = trial.robot.description, trial.robot
    q = np.array(trial.rows)
    lower, upper = robot.alone.jnt_range[: q.shape[1]].T
    assert (q >= lower - POSITION).all() and (q <= upper + POSITION).all()
    rest = np.repeat(q[:1], 3, axis=0), q, np.repeat(q[-1:], 3, axis=0)
    v, a, j = (np.diff(np.concatenate(rest), n, axis=0) / STEP**n for n in (1, 2, 3))
    share = 1.0 - description.limit_margin
    for name, values, tolerance in (
        ("velocity", v, VELOCITY),
        ("acceleration", a, ACCELERATION),
        ("jerk", j, JERK),
    ):
        use = np.abs(values).max(axis=0) / (share * np.array(getattr(description, name)))
        assert use.max() <= 1.0 + tolerance, name
    model = trial.arm.model
    rows = zip(trial.rows[::10], trial.rates[::10], strict=True)
    efforts = [np.abs(model.effort(row, *rates)) / model.limits.effort for row, rates in rows]
    assert np.max(efforts) <= EFFORT
    tool = np.array([trial.tool_pose(row).translation for row in q])
    speeds = np.linalg.norm(np.diff(tool, axis=0), axis=1) / STEP
    assert speeds.max(initial=0.0) <= tool_speed
    low, high = trial.box
    assert (tool >= low - OUTSIDE).all() and (tool <= high + OUTSIDE).all()


def check_goal(trial):
    goal, q = trial.goal, trial.arm.q
    assert not trial.arm.v.any() and not trial.arm.a.any()
    if goal is not None and goal.q is not None:
        np.testing.assert_allclose(q, goal.q, atol=1e-9)
    if goal is not None and goal.T_wt is not None:
        error = pin.log6(goal.T_wt.actInv(trial.tool_pose(q))).np
        assert np.abs(error).max() <= AT_GOAL


COMBINED = [("scale", "blend"), ("blend", "stop"), ("blend", "pause"), ("path", "pause")]


@pytest.mark.parametrize("kinds", [*((kind,) * 2 for kind in REQUESTS), *COMBINED], ids="-".join)
def test_they_are_kept_with_requests_of_each_kind(kinds):
    requests = list(zip(kinds, (0.3, 0.6), strict=True))
    check(robot_named("panda", ""), seed=3, requests=requests, tool_speed=0.25, boxed=False)


# The speed of the tool has a narrow peak after the scale is raised again.
@example(
    arm=1084,
    seed=1084,
    requests=[("scale", 0.8426397385677347), ("servo", 0.05014041603651587)],
    tool_speed=0.25,
    boxed=False,
)
# It is resumed while it brakes and the limits allow no change.
@example(arm=1744, seed=1744, requests=[("pause", 0.00814)], tool_speed=0.25, boxed=True)
@given(arm=st.integers(0, 2**32 - 1), **TRIALS)
@FAST
def test_they_are_kept_by_random_arms(arm, **trial):
    check(random_arm(arm), **trial)


@given(**TRIALS)
@FAST
def test_they_are_kept_by_an_arm_of_six_joints(menagerie, **trial):
    check(robot_named("ur5e", menagerie), **trial)


@pytest.mark.soak
@given(arm=st.integers(0, 2**32 - 1), **TRIALS)
@LONG
def test_they_are_kept_by_500_random_arms(arm, **trial):
    check(random_arm(arm), **trial)


@pytest.mark.soak
@pytest.mark.parametrize("name", ["panda", *MENAGERIE_ARMS])
@given(**TRIALS)
@LONG
def test_they_are_kept_by_known_arms_in_500_trials(request, name, **trial):
    folder = "" if name == "panda" else request.getfixturevalue("menagerie")
    check(robot_named(name, folder), **trial)
