"""Problems compiled for an arm; the oracle is forward kinematics."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.kinematics import IKProblem, PoseTarget, PositionTarget, RotationTarget
from tests.measuring.kinematics import frame_pose, position_error, refused, rotation_error

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)
GRIP = PoseTarget("tool", DOWN)


def test_a_world_of_another_arm_is_refused(model, ik, walled):
    problem = IKProblem(targets=GRIP, world=walled.world)
    message = "the CollisionWorld is that of an arm with panda/joint1, .* this one has joint1,"
    refused(lambda: ik.solve(problem, model.home), message)
    refused(lambda: ik.follow(problem, model.home), message)


def test_a_position_alone_leaves_the_rotation_free_and_the_other_way_round(model, ik, goal):
    T = model.pose(goal).copy()
    targets = PositionTarget("tool", T.translation), RotationTarget("tool", T.rotation)
    for alone, target in enumerate(targets):
        found = ik.solve(IKProblem(targets=[target]), model.home)
        errors = [position_error(model, found.q, "tool", T.translation)]
        errors.append(rotation_error(model, found.q, "tool", T.rotation))
        assert found.solved and errors[alone] <= 1e-6 and errors[1 - alone] > 0.01


def test_a_wide_tolerance_is_freedom_for_the_other_targets(model, ik):
    high = pin.SE3(DOWN.rotation, np.array([0.68, 0.0, 0.62]))
    strict = IKProblem(targets=[PoseTarget("tool", high)])
    assert not ik.solve(strict, model.home, restarts=5).solved
    tilted = IKProblem(targets=[PoseTarget("tool", high, tolerance=(1e-6, 0.8))])
    found = ik.solve(tilted, model.home)
    assert found.solved
    assert position_error(model, found.q, "tool", high.translation) <= 1e-6
    assert 0.1 < rotation_error(model, found.q, "tool", high.rotation) <= 0.8


def test_residuals_have_the_order_of_the_targets(model, ik):
    elbow = np.array([0.0, 0.4, 0.6])
    targets = [PoseTarget("tool", DOWN), PositionTarget("link4", elbow, weight=0.1)]
    found = ik.solve(IKProblem(targets=targets), model.home)
    tool, other = found.residuals
    assert (tool.frame, other.frame) == ("tool", "link4")
    assert tool.met and max(tool.position, tool.rotation) <= 1e-6
    assert other.position == pytest.approx(
        position_error(model, found.q, "link4", elbow), abs=1e-12
    )
    assert other.rotation == 0.0


def test_only_the_chosen_joints_move_and_their_names_may_come_from_a_generator(model, ik):
    moving = ("joint2", "joint4", "joint6")
    goal = model.home + np.array([0.0, 0.2, 0.0, -0.3, 0.0, 0.25, 0.0])
    target = PositionTarget("tool", model.pose(goal).translation)
    problem = IKProblem(targets=target, joints=(name for name in moving))
    first, second = (ik.solve(problem, model.home) for _ in range(2))
    assert first.solved and np.array_equal(first.q, second.q)
    assert problem.joints == moving
    assert np.array_equal(first.q[[0, 2, 4, 6]], model.home[[0, 2, 4, 6]])


def test_a_moved_base_moves_the_targets_the_opposite_way(model, ik):
    T_wb = pin.SE3(pin.exp3(np.array([0.0, 0.0, 0.7])), np.array([1.0, -2.0, 0.3]))
    stands = frame_pose(model, model.home, "link0")
    T = T_wb * stands.inverse() * DOWN  # the same, seen from the base
    found = ik.solve(IKProblem(targets=PoseTarget("tool", T), base=T_wb), model.home)
    assert found.solved
    assert max(np.abs(pin.log6(model.pose(found.q).actInv(DOWN)).np)) <= 1e-6
    position = PositionTarget("tool", T.translation)
    rotation = RotationTarget("tool", T.rotation)
    found = ik.solve(IKProblem(targets=[position, rotation], base=T_wb), model.home)
    assert max(np.abs(pin.log6(model.pose(found.q).actInv(DOWN)).np)) <= 2e-6


def test_one_margin_or_one_for_each_joint_is_kept(model, ik, rng):
    limits = model.limits
    for margin in (0.2, np.linspace(0.0, 0.3, 7)):
        goal = rng.uniform(limits.lower + margin, limits.upper - margin)
        found = ik.solve(
            IKProblem(targets=PoseTarget("tool", model.pose(goal)), margin=margin), model.home
        )
        assert found.solved
        assert (found.q >= limits.lower + margin).all() and (found.q <= limits.upper - margin).all()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"targets": PositionTarget("tol", np.zeros(3))}, "no frame 'tol'; did you mean 'tool'"),
        ({"joints": ["joint9"]}, "no joint 'joint9'; did you mean 'joint"),
        ({"joints": []}, "at least one joint that may move"),
        *(
            ({"margin": margin}, "margin must be at least 0 .rad., one number or 7")
            for margin in (np.nan, "0.1", [], [0.1] * 6, np.full(7, -1))
        ),
        ({"margin": 2.0}, "a margin of 2 rad leaves joint2 no range"),
        *(
            ({"posture": posture}, "posture must be 7 finite numbers")
            for posture in ("up", np.zeros(6))
        ),
    ],
)
def test_what_does_not_fit_the_arm_is_refused_by_name(model, ik, changed, message):
    problem = IKProblem(**{"targets": GRIP, **changed})
    for ask in (ik.solve, ik.follow):
        refused(lambda ask=ask: ask(problem, model.home), message)


def test_a_pose_with_a_free_axis_is_met_only_where_both_position_and_axis_are(model, compiled):
    T = model.pose(model.home)
    turned, tilted = (
        pin.SE3(T.rotation @ pin.exp3(by), T.translation)
        for by in (np.array([0.0, 0.0, 0.3]), np.array([0.3, 0.0, 0.0]))
    )
    aside = pin.SE3(T.rotation, T.translation + [0.0, 0.05, 0.0])
    for goal, met in ((turned, True), (tilted, False), (aside, False)):
        problem = IKProblem(targets=PoseTarget("tool", goal, free_axis=(0.0, 0.0, 1.0)))
        (error,) = compiled(problem).errors(model.home)
        assert error.met is met
        assert error.position == pytest.approx(0.05 * (goal is aside), abs=1e-9)
        assert error.rotation == pytest.approx(0.3 * (goal is tilted), abs=1e-6)
