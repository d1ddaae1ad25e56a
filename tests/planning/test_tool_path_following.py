"""Motions along tool paths."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import InverseKinematics
from bt_manip.planning import ArcTo, LineTo, TurnAbout, follow_tool_path, tool_paths
from bt_manip.planning.tool_path_following import limit_error
from bt_manip.robots import ToolLimits
from bt_manip.trajectories import SplinePath, effort_use, limit_use

from .test_tool_path import CORNER, END, START


@pytest.fixture
def at_start(arm) -> Arm:
    arm.reset(arm.ik.nearest(START, arm.model.home).q)
    return arm


@pytest.mark.parametrize(
    ("steps", "blend"),
    [
        ([LineTo(CORNER), LineTo(END)], 0.0),
        ([ArcTo([0.5, 0.0, 0.35], CORNER)], 0.0),
        ([TurnAbout([0.4, 0.0, 0.3], [0.0, 0.0, 1.0], -1.0)], 0.0),
        ([LineTo(CORNER), ArcTo([0.5, 0.2, 0.35], END)], 0.04),
    ],
    ids=["halting", "arc", "turn", "line and arc"],
)
def test_a_path_is_followed_to_its_end_inside_all_limits(at_start, steps, blend):
    arm = at_start
    paths = tool_paths(arm.model.pose(arm.q), steps, blend)
    arm.move_path(steps, blend=blend)
    trajectory = arm.trajectory
    assert limit_use(trajectory, arm.model.limits).inside
    assert effort_use(trajectory, arm.model) <= 0.96
    q, *_ = trajectory.sample(np.linspace(0.0, trajectory.duration, 100))
    poses = [path.pose(s) for path in paths for s in np.linspace(0.0, 1.0, 2001)]
    near = np.array([T.translation for T in poses])
    for x in q:
        T = arm.model.pose(x)
        far = np.linalg.norm(near - T.translation, axis=1)
        assert far.min() < 3e-4
        beside = [poses[i] for i in np.flatnonzero(far < far.min() + 5e-4)]
        off = min(np.linalg.norm(pin.log3(T.rotation.T @ other.rotation)) for other in beside)
        assert off < 4e-3
    while arm.moving:
        arm.advance(1e-3)
    assert np.abs(pin.log6(paths[-1].pose(1.0).actInv(arm.model.pose(arm.q))).np).max() < 1e-5


@pytest.mark.parametrize("blend", [0.0, 0.04])
def test_the_tool_keeps_its_limits(at_start, blend, monkeypatch):
    arm = at_start
    limits = ToolLimits(velocity=0.25, acceleration=1.5, angular_velocity=0.6)
    for model in (arm.model, arm.ik.model):
        monkeypatch.setattr(model, "limits", replace(model.limits, tool=limits))
    arm.move_path([LineTo(CORNER), ArcTo([0.5, 0.2, 0.35], END), LineTo(START)], blend=blend)
    q, v, _ = arm.trajectory.sample(np.arange(0.0, arm.trajectory.duration, 1e-3))
    rates = np.array([arm.model.jacobian(x) @ u for x, u in zip(q, v, strict=True)])
    linear, angular = rates[:, :3], rates[:, 3:]
    speed = np.linalg.norm(linear, axis=1)
    assert 0.95 * 0.25 < speed.max() <= 1.001 * 0.25
    slowest = speed[60:-60].min()  # it stops in corners that are not blended
    assert slowest > 0.03 if blend else slowest < 1e-3
    assert np.linalg.norm(angular, axis=1).max() <= 1.001 * 0.6
    acceleration = np.linalg.norm(np.gradient(linear, 1e-3, axis=0), axis=1)
    assert acceleration.max() <= 1.02 * 1.5


@pytest.mark.parametrize("blend", [0.0, 0.03])
def test_a_path_that_leaves_the_workspace_is_refused_with_its_share_inside(at_start, blend):
    far = spatial.pointing_down([1.4, 0.1, 0.3], 0.5)
    with pytest.raises(MotionError, match=r"the path can be followed only for \d+ %") as e:
        at_start.move_path([LineTo(CORNER), LineTo(far)], blend=blend)
    assert e.value.reason == "line" and not at_start.moving
    # Of 0.3 m to the corner and 1 m from there, it may get along x to where the arm is stretched.
    assert "of 1.300 m" in str(e.value)
    assert 0.3 / 1.3 < e.value.fraction < (0.3 + 0.5) / 1.3


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_line_is_followed_with_a_joint_along_its_limit(model, ik, side):
    q0 = np.array([-1.072, -0.626, 0.458, -2.31, 0.266, 1.729, 2.847])  # joint 7 by its limit
    q0[::2] *= side
    start = model.pose(q0)
    down = pin.SE3(start.rotation, start.translation - [0.0, 0.0, 0.385])
    (path,) = tool_paths(start, [LineTo(down)])
    curve = follow_tool_path(ik, q0, path)
    q = curve.evaluate(np.linspace(0.0, 1.0, 3000), 0)[0][:, : model.nq]
    assert np.minimum(model.limits.upper - q, q - model.limits.lower)[:, 6].min() < 0.01
    assert model.limits.contain(q, 1e-9)
    assert np.abs(model.pose(q[-1]).translation - down.translation).max() <= 1e-7


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-4])
@pytest.mark.parametrize("turned", [False, True])
def test_tiny_motions_are_inside_all_limits_too(at_start, size, turned):
    arm = at_start
    T = arm.model.pose(arm.q)
    little = np.array([0.0, 0.0, size])
    aside = pin.SE3(pin.exp3(little), np.zeros(3)) if turned else pin.SE3(np.eye(3), little)
    arm.move_linear(T * aside)
    assert 0.0 < arm.remaining < 0.05
    assert limit_use(arm.trajectory, arm.model.limits).inside
    while arm.moving:
        arm.advance(1e-3)
    assert np.abs(pin.log6(arm.model.pose(arm.q).actInv(T * aside)).np).max() <= 2e-8


def test_a_line_near_a_singularity_is_followed_inside_all_limits(arm):
    arm.reset([2.558, -0.092, 1.678, -1.425, 1.705, 0.252, -0.388])  # nearly singular
    start = arm.model.pose(arm.q)
    along = np.array([0.108, 0.199, 0.005])
    arm.move_linear(pin.SE3(start.rotation, start.translation + along))
    assert limit_use(arm.trajectory, arm.model.limits).inside
    direction = along / np.linalg.norm(along)
    for q in arm.trajectory.sample(np.arange(0.0, arm.remaining, 0.02))[0]:
        gone = arm.model.pose(q).translation - start.translation
        assert np.linalg.norm(gone - direction * (direction @ gone)) <= 6e-5


def test_a_turn_is_slow_only_where_a_joint_reaches_its_limit(arm):
    arm.reset([-0.181, -0.117, -0.233, -2.318, -0.033, 2.204, 0.392])
    place = arm.model.pose(arm.q).translation
    arm.move_path([TurnAbout(place, (0.0, 0.0, 1.0), -np.pi)])
    trajectory, limits = arm.trajectory, arm.model.limits
    assert limit_use(trajectory, limits).inside and effort_use(trajectory, arm.model) <= 0.96
    q, v, _ = trajectory.sample(np.arange(0.0, trajectory.duration, 1e-3))
    assert limits.upper[6] - q[:, 6].max() < 0.01
    before = (q[:, 6] > 0.8) & (q[:, 6] < 2.2)
    assert (np.abs(v[before]) / limits.velocity).max(axis=1).min() > 0.8
    # A lower bound of the duration: from knot to knot no joint is faster than its limit.
    steps = np.abs(np.diff(trajectory.path.knots[:, :7], axis=0))
    assert trajectory.duration < 2.0 * (steps / limits.velocity).max(axis=1).sum()
    assert max(np.abs(arm.model.pose(x).translation - place).max() for x in q) <= 5e-5


def test_an_empty_path_is_no_motion(at_start):
    T = at_start.model.pose(at_start.q)
    at_start.move_path([])
    at_start.move_path([LineTo(T), LineTo(T)], blend=0.01)
    assert not at_start.moving


def test_a_straight_line_is_followed_within_the_tolerance_of_the_arm(five_joints):
    model = five_joints.make_model()
    ik, start = InverseKinematics(model), model.pose(model.home)
    end = pin.SE3(start.rotation, start.translation - [0.0, 0.0, 0.2])
    (line,) = tool_paths(start, [LineTo(end)])
    curve = follow_tool_path(ik, model.home, line)
    for row in curve.evaluate(np.linspace(0.0, 1.0, 101), 0)[0]:
        error = line.pose(row[-1]).actInv(model.pose(row[:5]))
        assert np.linalg.norm(error.translation) <= 1e-5 + 5e-5
        assert np.linalg.norm(pin.log3(error.rotation)) <= 1e-4 + 5e-5


def test_a_joint_that_leaves_its_limits_between_the_ends_of_a_spline_is_named(model):
    s = np.linspace(0.0, 1.0, 11)[:, np.newaxis]
    lower, upper = model.limits.lower, model.limits.upper
    middle = 0.5 * (lower + upper)
    bump = 4.0 * s * (1.0 - s)  # a quintic spline has it exactly
    for share, named in ((0.95, ""), (1.05, ": joint 2 would leave its limits")):
        beyond = share * (np.arange(len(middle)) == 1) * (upper - middle)
        curve = SplinePath(middle + bump * beyond)
        assert limit_error(curve, model.limits) == named
