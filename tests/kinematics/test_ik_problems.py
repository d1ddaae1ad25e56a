"""Inverse kinematics as one states it; the oracles are forward kinematics and differences."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import (
    IKProblem,
    InverseKinematics,
    PoseTarget,
    PositionTarget,
    RotationTarget,
    manipulability,
)
from bt_manip.kinematics.compiled_problem import compile_problem
from bt_manip.kinematics.manipulability import manipulability_gradient
from bt_manip.kinematics.residuals import (
    PoseResidual,
    PositionResidual,
    RotationResidual,
    StackedResidual,
)
from bt_manip.kinematics.secondary_objectives import SecondaryObjectives
from bt_manip.robots import Robot, RobotDescription, compile_alone

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)


@pytest.fixture
def goal(model, rng):
    return rng.uniform(model.limits.lower + 0.1, model.limits.upper - 0.1)


def frame_pose(model, q, name):
    """Pose of a frame, by Pinocchio's forward kinematics on data of its own."""
    data = model.model.createData()
    pin.framesForwardKinematics(model.model, data, q)
    return data.oMf[model.model.getFrameId(name)].copy()


def distance(model, q, name, place):
    return np.linalg.norm(frame_pose(model, q, name).translation - place)


def angle(model, q, name, rotation):
    return np.linalg.norm(pin.log3(frame_pose(model, q, name).rotation.T @ rotation))


# Targets


def test_a_position_alone_leaves_the_rotation_free(model, ik, goal):
    place = model.pose(goal).translation
    found = ik.solve(IKProblem(targets=[PositionTarget("tool", place)]), model.home)
    assert found.solved and distance(model, found.q, "tool", place) <= 1e-6
    assert angle(model, found.q, "tool", model.pose(goal).rotation) > 0.01


def test_a_rotation_alone_leaves_the_position_free(model, ik, goal):
    rotation = model.pose(goal).rotation
    found = ik.solve(IKProblem(targets=[RotationTarget("tool", rotation)]), model.home)
    assert found.solved and angle(model, found.q, "tool", rotation) <= 1e-6
    assert distance(model, found.q, "tool", model.pose(goal).translation) > 0.01


def test_several_frames_are_put_where_they_shall_be_at_once(model, ik, rng):
    for _ in range(20):
        q = rng.uniform(model.limits.lower, model.limits.upper)
        elbow, tool = frame_pose(model, q, "link4").translation, model.pose(q).translation
        problem = IKProblem(targets=[PositionTarget("link4", elbow), PositionTarget("tool", tool)])
        found = ik.solve(problem, model.home, rng=rng)
        assert found.solved and model.limits.contain(found.q)
        assert distance(model, found.q, "link4", elbow) <= 1e-6
        assert distance(model, found.q, "tool", tool) <= 1e-6


def test_a_pose_target_of_the_tool_is_as_good_as_a_pose(model, ik, rng):
    for _ in range(30):
        T = model.pose(rng.uniform(model.limits.lower, model.limits.upper))
        alone = ik.solve(T, model.home)
        stated = ik.solve(IKProblem(targets=PoseTarget("tool", T)), model.home)
        assert alone.solved and stated.solved
        assert np.array_equal(alone.q, stated.q)


def test_a_wide_tolerance_is_room_that_other_targets_may_use(model, ik):
    high = pin.SE3(DOWN.rotation, np.array([0.68, 0.0, 0.62]))
    strict = IKProblem(targets=[PoseTarget("tool", high)])
    assert not ik.solve(strict, model.home, restarts=5).solved
    tilted = IKProblem(targets=[PoseTarget("tool", high, tolerance=(1e-6, 0.8))])
    found = ik.solve(tilted, model.home)
    assert found.solved
    assert distance(model, found.q, "tool", high.translation) <= 1e-6
    assert 0.1 < angle(model, found.q, "tool", high.rotation) <= 0.8


def test_a_cost_is_met_as_far_as_the_constraints_allow(model, ik):
    elbow = np.array([0.1, 0.5, 0.6])
    pose = PoseTarget("tool", DOWN)
    without = ik.solve(IKProblem(targets=[pose]), model.home)
    cost = PositionTarget("link4", elbow, weight=1.0)
    with_it = ik.solve(IKProblem(targets=[pose, cost]), model.home)
    assert with_it.solved
    assert distance(model, with_it.q, "tool", DOWN.translation) <= 1e-6
    near, far = (distance(model, r.q, "link4", elbow) for r in (with_it, without))
    assert near < far - 0.05
    assert with_it.cost == pytest.approx(0.5 * near**2, rel=1e-6)
    # Along the self-motion, the only way that the constraint leaves, the cost does not fall.
    *_, rows = np.linalg.svd(model.jacobian(with_it.q))
    costs = [
        distance(model, with_it.q + s * rows[6], "link4", elbow) ** 2 for s in (-2e-2, 0.0, 2e-2)
    ]
    assert costs[1] <= min(costs) + 1e-5


def test_costs_alone_end_where_their_sum_is_least(model, ik):
    beyond = np.array([1.5, 0.0, 0.333])
    found = ik.solve(IKProblem(targets=PositionTarget("tool", beyond, weight=1.0)), model.home)
    assert found.solved
    assert model.pose(found.q).translation[0] > 0.8
    # Nothing near it reaches nearer.
    here = distance(model, found.q, "tool", beyond)
    rng = np.random.default_rng(0)
    for _ in range(300):
        q = np.clip(found.q + rng.normal(0.0, 0.05, 7), model.limits.lower, model.limits.upper)
        assert distance(model, q, "tool", beyond) > here - 1e-4


def test_the_residual_of_each_target_is_told_in_their_order(model, ik):
    elbow = np.array([0.0, 0.4, 0.6])
    targets = [PoseTarget("tool", DOWN), PositionTarget("link4", elbow, weight=0.1)]
    found = ik.solve(IKProblem(targets=targets), model.home)
    tool, other = found.residuals
    assert (tool.frame, other.frame) == ("tool", "link4")
    assert tool.met and max(tool.position, tool.rotation) <= 1e-6
    assert other.position == pytest.approx(distance(model, found.q, "link4", elbow), abs=1e-12)
    assert other.rotation == 0.0


# Where to search


def test_only_the_chosen_joints_move(model, ik, rng):
    q0 = model.home.copy()
    goal = q0.copy()
    goal[[1, 3, 5]] += [0.2, -0.3, 0.25]
    problem = IKProblem(
        targets=PositionTarget("tool", model.pose(goal).translation),
        joints=["joint2", "joint4", "joint6"],
    )
    found = ik.solve(problem, q0, rng=rng)
    assert found.solved
    assert np.array_equal(found.q[[0, 2, 4, 6]], q0[[0, 2, 4, 6]])


def test_a_moved_base_moves_the_targets_the_other_way(model, ik):
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


def test_a_margin_is_kept_by_every_joint_or_by_each_its_own(model, ik, rng):
    limits = model.limits
    for margin in (0.2, np.linspace(0.0, 0.3, 7)):
        goal = rng.uniform(limits.lower + margin, limits.upper - margin)
        found = ik.solve(
            IKProblem(targets=PoseTarget("tool", model.pose(goal)), margin=margin), model.home
        )
        assert found.solved
        assert (found.q >= limits.lower + margin).all() and (found.q <= limits.upper - margin).all()


def test_a_solution_is_free_of_what_it_would_touch_otherwise(walled):
    ik, world = walled.ik, walled.world
    # Behind the wall: from home the elbow or the hand would go through it.
    rng = np.random.default_rng(4)
    touching = 0
    for _ in range(12):
        place = rng.uniform([0.3, -0.12, 0.1], [0.6, -0.06, 0.35])
        target = PositionTarget("panda/tool", place)
        careless = ik.solve(IKProblem(targets=target), ik.model.home, rng=np.random.default_rng(1))
        careful = ik.solve(
            IKProblem(targets=target, world=world), ik.model.home, rng=np.random.default_rng(1)
        )
        touching += bool(world.collisions(careless.q))
        assert careful.solved and not world.collisions(careful.q)
    assert touching > 3


def test_where_no_solution_is_free_the_reason_names_what_is_in_the_way(walled):
    inside = spatial.pointing_down((0.5, 0.0, 0.2))
    problem = IKProblem(targets=PoseTarget("panda/tool", inside), world=walled.world)
    found = walled.ik.solve(problem, walled.ik.model.home)
    assert not found.solved
    assert "no collision-free solution from 81 initial guesses: 'panda/" in found.reason
    assert "would touch 'wall'" in found.reason


# What solutions should be like


def test_a_posture_is_neared_along_the_self_motion(model, ik):
    posture = model.home + np.array([0.5, 0.0, -0.4, 0.0, 0.3, 0.0, 0.0])
    plain = ik.solve(DOWN, model.home)
    found = ik.solve(IKProblem(targets=PoseTarget("tool", DOWN), posture=posture), model.home)
    assert found.solved and ik.distance(found.q, posture) < ik.distance(plain.q, posture) - 1e-3
    *_, rows = np.linalg.svd(model.jacobian(found.q))
    slope = (found.q - posture) / model.limits.velocity**2 @ rows[6]
    assert abs(slope) < 0.02 * np.linalg.norm((found.q - posture) / model.limits.velocity**2)


def test_manipulability_is_raised_where_the_target_leaves_freedom(model, ik):
    rotation = RotationTarget("tool", DOWN.rotation)
    start = model.home + np.array([0.0, 0.6, 0.0, 1.6, 0.0, -1.0, 0.0])
    plain = ik.solve(IKProblem(targets=rotation), start)
    able = ik.solve(IKProblem(targets=rotation, manipulability=1.0), start)
    assert able.solved and angle(model, able.q, "tool", DOWN.rotation) <= 1e-6
    before, after = (manipulability(model.jacobian(r.q)) for r in (plain, able))
    assert after > 1.2 * before
    assert able.cost == pytest.approx(-np.log(after), rel=1e-6)


def test_solutions_of_a_problem_are_distinct_and_the_cheapest_comes_first(model, ik, goal, rng):
    T, elbow = model.pose(goal), PositionTarget("link4", [0.0, 0.4, 0.6], weight=1.0)
    problem = IKProblem(targets=[PoseTarget("tool", T), elbow])
    found = ik.solutions(problem, model.home, restarts=30, rng=rng)
    assert len(found) >= 2
    costs = [result.cost for result in found]
    assert costs == sorted(costs)
    for i, result in enumerate(found):
        assert result.solved and distance(model, result.q, "tool", T.translation) <= 1e-6
        assert all(np.abs(result.q - other.q).max() > 0.1 for other in found[:i])


def test_without_preferences_the_solution_nearest_to_the_start_comes_first(model, ik):
    elbow = RotationTarget("link6", frame_pose(model, model.home, "link6").rotation)
    problem = IKProblem(targets=[PositionTarget("tool", [0.4, 0.3, 0.4]), elbow])
    found = ik.solutions(problem, model.home, restarts=40)
    distances = [ik.distance(result.q, model.home) for result in found]
    assert len(found) >= 2 and distances == sorted(distances)
    assert all(result.cost == 0.0 for result in found)


def test_following_a_problem_never_steps_far_and_drifts_to_the_posture(model, ik):
    posture = model.home + np.array([0.4, 0.0, -0.3, 0.0, 0.0, 0.0, 0.0])
    q = ik.solve(DOWN, model.home).q
    began = ik.distance(q, posture)
    for i in range(1, 31):
        T = pin.SE3(DOWN.rotation, DOWN.translation + [0.0, 0.004 * i, 0.0])
        problem = IKProblem(targets=PoseTarget("tool", T), posture=posture)
        found = ik.follow(problem, q)
        assert found.solved and np.abs(found.q - q).max() <= 0.2 + 1e-12
        q = found.q
    assert ik.distance(q, posture) < began


def test_following_into_something_says_what_would_be_touched(walled):
    q = walled.ik.solve(walled.left, walled.ik.model.home).q
    reason = ""
    for y in np.arange(0.25, 0.0, -0.02):
        T = pin.SE3(walled.left.rotation, np.array([0.5, y, 0.12]))
        found = walled.ik.follow(
            IKProblem(targets=PoseTarget("panda/tool", T), world=walled.world), q
        )
        if not found.solved:
            reason = found.reason
            break
        q = found.q
    assert "'panda/" in reason and "would touch 'wall'" in reason


# Chance


def test_the_same_problem_and_seed_give_the_same_bits(model, ik, goal):
    problem = IKProblem(
        targets=[
            PositionTarget("link4", frame_pose(model, goal, "link4").translation),
            PositionTarget("tool", model.pose(goal).translation),
        ]
    )
    first = ik.solve(problem, model.home, rng=np.random.default_rng(5))
    ik.solve(DOWN, model.home)
    second = ik.solve(problem, model.home, rng=np.random.default_rng(5))
    assert np.array_equal(first.q, second.q) and first.iterations == second.iterations


# Derivatives


def rows_of(model, goal, kind):
    frame = model.model.getFrameId("link6")
    T = frame_pose(model, goal, "link6")
    return {
        "position": lambda: PositionResidual(model, frame, T.translation, 1e-6),
        "rotation": lambda: RotationResidual(model, frame, T.rotation, 1e-6),
        "wide position": lambda: PositionResidual(model, frame, T.translation, 0.1),
        "wide rotation": lambda: RotationResidual(model, frame, T.rotation, 0.02),
        "weighted position": lambda: PositionResidual(model, frame, T.translation, np.inf, 3.0),
    }[kind]()


def differences(f, q, h=1e-6):
    steps = h * np.eye(len(q))
    return np.stack([(f(q + d) - f(q - d)) / (2.0 * h) for d in steps], axis=-1)


@pytest.mark.parametrize(
    "kind",
    ["position", "rotation", "wide position", "wide rotation", "weighted position"],
)
def test_the_jacobian_of_each_error_is_its_derivative(model, goal, kind):
    system = StackedResidual(model, [rows_of(model, goal, kind)])
    q = goal + 0.3 * np.sin(np.arange(7.0))

    expected = differences(system.evaluate, q)
    assert np.abs(system.evaluate(q)).max() > 0.01
    assert system.jacobian() == pytest.approx(expected, abs=1e-7)


def test_the_jacobian_of_a_pose_nears_its_derivative_towards_the_pose(model, goal):
    frame = model.model.getFrameId("link6")
    system = StackedResidual(
        model, [PoseResidual(model, frame, frame_pose(model, goal, "link6"), (1e-6, 1e-6))]
    )
    for offset in (0.1, 1e-3, 1e-5):
        q = goal + offset * np.sin(np.arange(7.0))
        expected = differences(system.evaluate, q)
        error = np.linalg.norm(system.evaluate(q))
        assert np.abs(system.jacobian() - expected).max() <= error + 1e-8


def test_the_manipulability_is_the_volume_and_its_slope_is_its_derivative(model, rng):
    for _ in range(5):
        q = rng.uniform(model.limits.lower, model.limits.upper)
        jacobian = model.jacobian(q)
        volume = np.sqrt(np.linalg.det(jacobian @ jacobian.T))
        assert manipulability(jacobian) == pytest.approx(volume, rel=1e-9)
        expected = differences(lambda q: np.log(manipulability(model.jacobian(q))), q)
        assert manipulability_gradient(jacobian) == pytest.approx(expected, rel=1e-5, abs=1e-6)


def test_the_gradient_of_all_costs_is_their_derivative(model, ik, goal):
    problem = IKProblem(
        targets=[PoseTarget("link6", frame_pose(model, goal, "link6"), weight=2.0)],
        posture=model.home,
        posture_weight=0.5,
        manipulability=0.3,
    )
    joints = tuple(model.model.names)[1:]
    task = compile_problem(model, joints, problem, model.home, 1.0 / model.limits.velocity)
    assert isinstance(task.objectives, SecondaryObjectives)
    q = goal + 0.2
    expected = differences(task.cost, q)
    task.constraints.evaluate(q)
    expansion = task.objectives.expand(task.constraints)
    assert expansion.gradient == pytest.approx(expected, rel=1e-5, abs=1e-6)
    assert expansion.value == pytest.approx(task.cost(q))


# Other arms


def test_an_arm_of_six_joints_has_the_same_problems(menagerie, rng):
    joints = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    robot = Robot(
        RobotDescription(
            name="ur5e",
            model=str(menagerie / "universal_robots_ur5e" / "ur5e.xml"),
            arm_joints=tuple(f"{joint}_joint" for joint in joints),
            tool_frame="attachment_site",
            home=(0.0, -1.5, 1.5, -1.5, -1.5, 0.0),
            velocity=(2.0,) * 6,
            acceleration=(5.0,) * 6,
            jerk=(1000.0,) * 6,
            effort=(50.0,) * 6,
        )
    )
    compile_alone(robot)
    model = robot.make_model()
    ik = InverseKinematics(model)
    for _ in range(10):
        T = model.pose(rng.uniform(-2.5, 2.5, 6))
        place = PositionTarget("attachment_site", T.translation)
        elbow = PositionTarget("forearm_link", [0.0, 0.0, 0.9], weight=1.0)
        found = ik.solve(IKProblem(targets=[place, elbow], manipulability=0.1), model.home)
        assert found.solved
        assert distance(model, found.q, "attachment_site", T.translation) <= 1e-6
        posed = IKProblem(targets=PoseTarget("attachment_site", T), posture=model.home)
        assert ik.solve(posed, model.home).solved


# Bad input


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: PositionTarget("tool", [0.0, np.nan, 0.0]),
            "'tool': position must be 3 finite numbers .m.",
        ),
        (lambda: PositionTarget("tool", "here"), "must be 3 finite numbers"),
        (
            lambda: RotationTarget("tool", 2.0 * np.eye(3)),
            "frame 'tool': rotation must be a 3 by 3",
        ),
        (lambda: RotationTarget("tool", np.full((3, 3), np.nan)), "3 by 3"),
        (
            lambda: PoseTarget("tool", np.eye(4)),
            "frame 'tool': pose must be a pin.SE3, got ndarray",
        ),
        (lambda: PositionTarget(3, [0.0, 0.0, 0.0]), "frame of a target must be a name, got 3"),
        (
            lambda: PositionTarget("tool", np.zeros(3), weight=-1.0),
            "weight must be above 0, got -1.0",
        ),
        (
            lambda: PositionTarget("tool", np.zeros(3), tolerance=0.0),
            "tolerance must be above 0, got 0",
        ),
        (lambda: PositionTarget("tool", np.zeros(3), tolerance=(1.0, 1.0)), "above 0, got"),
        (lambda: PoseTarget("tool", DOWN, tolerance=(1.0, np.nan)), "or a pair of position and"),
        (
            lambda: PositionTarget("tool", np.zeros(3), weight=1.0, tolerance=1.0),
            "must be a cost with",
        ),
        (lambda: IKProblem(), "it has no targets"),
        (lambda: IKProblem(targets=[DOWN]), "a target must be a PositionTarget, .* got SE3"),
        (
            lambda: IKProblem(targets=PoseTarget("tool", DOWN), base=np.eye(4)),
            "base must be a pin.SE3, got ndarray",
        ),
        (
            lambda: IKProblem(posture=np.zeros(7), posture_weight=0.0),
            "posture_weight must be above 0",
        ),
        (lambda: IKProblem(manipulability=np.nan), "manipulability must be at least 0, got nan"),
    ],
)
def test_what_cannot_be_meant_is_refused_by_name(make, message):
    with pytest.raises(MotionError, match=message) as raised:
        make()
    assert raised.value.reason == "target"


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"targets": PositionTarget("tol", np.zeros(3))}, "no frame 'tol'; did you mean 'tool'"),
        ({"joints": ["joint9"]}, "no joint 'joint9'; did you mean 'joint"),
        ({"joints": []}, "at least one joint that may move"),
        ({"margin": -0.1}, "margin must be at least 0"),
        ({"margin": [0.1, 0.2]}, "one number or 7"),
        ({"margin": 2.0}, "a margin of 2 rad leaves joint2 no range"),
        ({"posture": np.zeros(6)}, "posture must be 7 finite numbers"),
    ],
)
def test_what_does_not_fit_the_arm_is_refused_by_name(model, ik, changed, message):
    problem = IKProblem(**{"targets": PoseTarget("tool", DOWN), **changed})
    with pytest.raises(MotionError, match=message):
        ik.solve(problem, model.home)
    with pytest.raises(MotionError, match=message):
        ik.follow(problem, model.home)


def test_a_base_elsewhere_and_a_world_to_be_free_of_exclude_each_other(walled):
    with pytest.raises(MotionError, match="must not have both a base and a CollisionWorld"):
        IKProblem(targets=PoseTarget("tool", DOWN), base=DOWN, world=walled.world)


def test_following_from_what_is_no_configuration_is_refused(ik):
    with pytest.raises(MotionError, match="7 finite numbers"):
        ik.follow(DOWN, np.full(7, np.nan))


def test_a_target_is_a_copy(model):
    place = np.zeros(3)
    target = PositionTarget("tool", place)
    place[0] = 1.0
    assert target.position[0] == 0.0
    with pytest.raises(ValueError):
        target.position[0] = 2.0
