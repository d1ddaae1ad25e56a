"""Inverse kinematics; the oracle is forward kinematics, MuJoCo's where a solution is judged."""

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
)
from bt_manip.robots import Robot, RobotDescription, Tolerance, compile_alone
from tests.measuring.kinematics import (
    error_in_mujoco,
    frame_pose,
    position_error,
    random_configurations,
    refused,
)

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)
GRIP = PoseTarget("tool", DOWN)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"restarts": -1}, "restarts must be an integer of at least 0, got -1"),
        ({"restarts": 2.5}, "restarts must be an integer of at least 0, got 2.5"),
        ({"restarts": "many"}, "restarts must be an integer of at least 0, got 'many'"),
        ({"restarts": True}, "restarts must be an integer of at least 0, got True"),
        ({"rng": 3}, "rng must be a numpy.random.Generator, got 3"),
        ({"rng": 0}, "rng must be a numpy.random.Generator, got 0"),
        ({"rng": np.random.RandomState(0)}, "rng must be a numpy.random.Generator"),
    ],
)
def test_solve_refuses_invalid_arguments(model, ik, asked, message):
    refused(lambda: ik.solve(DOWN, model.home, **asked), message)
    refused(lambda: ik.solve(IKProblem(targets=GRIP), model.home, **asked), message)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"restarts": -1}, "restarts must be an integer of at least 0, got -1"),
        ({"restarts": 1.5}, "restarts must be an integer of at least 0, got 1.5"),
        ({"distinct": -0.1}, "distinct must be at least 0 .rad., got -0.1"),
        ({"distinct": np.nan}, "distinct must be at least 0 .rad., got nan"),
        ({"distinct": "0.1"}, "distinct must be at least 0 .rad., got '0.1'"),
        ({"rng": "seed"}, "rng must be a numpy.random.Generator, got 'seed'"),
        ({"margin": -0.1}, "margin must be at least 0 .rad., got -0.1"),
        ({"margin": np.nan}, "margin must be at least 0 .rad., got nan"),
    ],
)
def test_solutions_refuses_invalid_arguments(model, ik, asked, message):
    refused(lambda: ik.solutions(DOWN, model.home, **asked), message)
    refused(lambda: ik.solutions(IKProblem(targets=GRIP), model.home, **asked), message)


@pytest.mark.parametrize(
    ("asked", "message"),
    [
        ({"max_step": 0.0}, "max_step must be above 0 .rad., got 0.0"),
        ({"max_step": -0.2}, "max_step must be above 0 .rad., got -0.2"),
        ({"max_step": np.nan}, "max_step must be above 0 .rad., got nan"),
        ({"max_step": "0.2"}, "max_step must be above 0 .rad., got '0.2'"),
        ({"max_step": np.full(7, 0.2)}, "max_step must be above 0 .rad., got array"),
        ({"margin": -0.1}, "margin must be at least 0 .rad., got -0.1"),
        ({"margin": np.nan}, "margin must be at least 0 .rad., got nan"),
        ({"margin": np.full(7, 0.1)}, "margin must be at least 0 .rad., got array"),
        ({"tolerance": 0.0}, "tolerance must be above 0 .m, rad., got 0.0"),
        ({"tolerance": (1e-3, 1e-3)}, "tolerance must be above 0 .m, rad., got"),
        ({"tolerance": np.nan}, "tolerance must be above 0 .m, rad., got nan"),
        ({"retry": "no"}, "retry must be True or False, got 'no'"),
        ({"retry": np.zeros(2)}, "retry must be True or False, got array"),
    ],
)
def test_follow_refuses_invalid_arguments(model, ik, asked, message):
    refused(lambda: ik.follow(model.pose(model.home), model.home, **asked), message)
    refused(lambda: ik.follow(IKProblem(targets=GRIP), model.home, **asked), message)


def test_integers_serve_as_angles_too(model, ik):
    T = model.pose(model.home + 0.02)
    plain = ik.follow(T, model.home, max_step=1.0, margin=0.0)
    whole = ik.follow(T, model.home, max_step=1, margin=0)
    assert plain.solved and np.array_equal(plain.q, whole.q)


def test_a_margin_or_a_tolerance_beside_a_problem_is_refused(model, ik):
    problem = IKProblem(targets=GRIP)
    own = "a problem has its own margin: ask for IKProblem.margin=....*got margin=0.1"
    refused(lambda: ik.follow(problem, model.home, margin=0.1), own)
    refused(lambda: ik.solutions(problem, model.home, margin=0.1), own)
    each = "each target of a problem has its own tolerance: ask for PoseTarget"
    refused(lambda: ik.follow(problem, model.home, tolerance=1e-3), each)


def test_a_target_without_a_problem_is_refused_with_how_to_ask_for_it(model, ik):
    for ask in (ik.solve, ik.follow, ik.solutions):
        refused(
            lambda ask=ask: ask(GRIP, model.home),
            r"a pose or a problem, got the target of frame 'tool': ask for IKProblem",
        )


def test_nearest_refuses_an_invalid_margin_and_ignores_one_that_leaves_no_range(model, ik):
    for margin in (-0.1, np.nan, "wide"):
        refused(lambda margin=margin: ik.nearest(DOWN, model.home, margin=margin), "margin must be")
    found = ik.nearest(DOWN, model.home, margin=3.0)
    assert np.array_equal(found.q, ik.nearest(DOWN, model.home).q)
    assert ik.solutions(DOWN, model.home, margin=3.0) == []


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"restarts": -1}, "restarts must be an integer of at least 0, got -1"),
        ({"iterations": 1.5}, "iterations must be an integer of at least 0, got 1.5"),
        (
            {"max_failed_iterations": -1},
            "max_failed_iterations must be an integer .*, got -1",
        ),
        (
            {"max_failed_iterations": np.nan},
            "max_failed_iterations must be an integer .*, got nan",
        ),
        (
            {"max_failed_iterations": "600"},
            "max_failed_iterations must be an integer .*, got '600'",
        ),
        ({"seed": -1}, "seed must be an integer of at least 0, got -1"),
        ({"seed": "one"}, "seed must be an integer of at least 0, got 'one'"),
        ({"position_tolerance": 0.0}, "position_tolerance must be above 0 .m., got 0.0"),
        ({"rotation_tolerance": np.nan}, "rotation_tolerance must be above 0 .rad., got nan"),
    ],
)
def test_invalid_bounds_are_refused_by_the_constructor(model, given, message):
    refused(lambda: InverseKinematics(model, **given), message)


def test_only_a_robot_model_is_accepted(robot):
    message = "model must be a RobotModel .Robot.make_model., got Robot"
    refused(lambda: InverseKinematics(robot), message)


def test_a_distance_is_between_configurations(model, ik):
    refused(lambda: ik.distance(np.zeros(6), model.home), "configuration must be 7 finite numbers")
    refused(lambda: ik.distance(model.home, None), "configuration must be 7 finite numbers")
    assert ik.distance([0.0] * 7, [0.0] * 7) == 0.0


def test_solutions_of_a_problem_are_distinct_and_the_cheapest_comes_first(model, ik, goal, rng):
    T, elbow = model.pose(goal), PositionTarget("link4", [0.0, 0.4, 0.6], weight=1.0)
    problem = IKProblem(targets=[PoseTarget("tool", T), elbow])
    found = ik.solutions(problem, model.home, restarts=30, rng=rng)
    assert len(found) >= 2
    costs = [result.cost for result in found]
    assert costs == sorted(costs)
    for i, result in enumerate(found):
        assert result.solved and position_error(model, result.q, "tool", T.translation) <= 1e-6
        assert all(np.abs(result.q - other.q).max() > 0.1 for other in found[:i])


def test_without_costs_the_solution_nearest_to_the_present_configuration_comes_first(model, ik):
    elbow = RotationTarget("link6", frame_pose(model, model.home, "link6").rotation)
    problem = IKProblem(targets=[PositionTarget("tool", [0.4, 0.3, 0.4]), elbow])
    found = ik.solutions(problem, model.home, restarts=40)
    distances = [ik.distance(result.q, model.home) for result in found]
    assert len(found) >= 2 and distances == sorted(distances)
    assert all(result.cost == 0.0 for result in found)


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


def test_problems_of_an_arm_with_six_joints_are_solved(menagerie, rng):
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
        position = PositionTarget("attachment_site", T.translation)
        elbow = PositionTarget("forearm_link", [0.0, 0.0, 0.9], weight=1.0)
        found = ik.solve(IKProblem(targets=[position, elbow], manipulability=0.1), model.home)
        assert found.solved
        assert position_error(model, found.q, "attachment_site", T.translation) <= 1e-6
        posed = IKProblem(targets=PoseTarget("attachment_site", T), posture=model.home)
        assert ik.solve(posed, model.home).solved


def test_following_from_an_invalid_configuration_is_refused(ik):
    with pytest.raises(MotionError, match="7 finite numbers"):
        ik.follow(DOWN, np.full(7, np.nan))


def test_every_reachable_pose_is_solved_from_home_and_from_anywhere(robot, model, ik, rng):
    for q, q0 in zip(*random_configurations(model, rng, 400).reshape(2, 200, 7), strict=True):
        T = model.pose(q)
        for start in (model.home, q0):
            found = ik.solve(T, start)
            assert found.solved and found.reason == ""
            assert model.limits.contain(found.q)
            distance, angle = error_in_mujoco(robot, found.q, T)
            assert distance <= 1.001e-6 and angle <= 1.001e-6


def test_the_same_request_gives_the_same_bits(model, rng):
    q, q0 = random_configurations(model, rng, 2)
    T = model.pose(q)
    first, second = (InverseKinematics(model).solve(T, q0) for _ in range(2))
    assert np.array_equal(first.q, second.q)
    assert first.iterations == second.iterations


def test_earlier_requests_do_not_change_the_result(model, ik, rng):
    q, other, q0 = random_configurations(model, rng, 3)
    first = ik.solve(model.pose(q), q0)
    ik.solve(model.pose(other), other)
    assert np.array_equal(ik.solve(model.pose(q), q0).q, first.q)


def test_solutions_are_distinct_and_the_nearest_comes_first(robot, model, ik, rng):
    q0 = random_configurations(model, rng, 1)[0]
    T = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)
    found = ik.solutions(T, q0)
    assert len(found) >= 2
    distances = [ik.distance(solution.q, q0) for solution in found]
    assert distances == sorted(distances)
    for i, solution in enumerate(found):
        assert max(error_in_mujoco(robot, solution.q, T)) <= 1.001e-6
        assert all(np.abs(solution.q - other.q).max() > 0.1 for other in found[:i])


def test_the_nearest_solution_is_usually_nearer_than_those_from_random_guesses(model, ik, rng):
    nearer = 0
    for _ in range(20):
        q, q0 = random_configurations(model, rng, 2)
        T = model.pose(q)
        nearest = ik.distance(ik.nearest(T, q0).q, q0)
        others = [ik.solve(T, start).q for start in random_configurations(model, rng, 20)]
        nearer += nearest <= min(ik.distance(other, q0) for other in (q, *others)) + 1e-3
    assert nearer >= 18


def test_among_equivalent_poses_the_nearest_is_chosen(model, ik):
    yaws = (0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi)
    poses = [spatial.pointing_down([0.4, 0.0, 0.3], yaw) for yaw in yaws]
    found = ik.nearest(poses, model.home)
    alone = [ik.nearest(pose, model.home) for pose in poses]
    distances = [ik.distance(result.q, model.home) for result in alone]
    assert found.target == int(np.argmin(distances))
    assert ik.distance(found.q, model.home) <= min(distances) + 1e-9


def test_a_margin_from_the_limits_is_kept_where_that_is_possible(model, ik):
    found = ik.nearest(spatial.pointing_down([0.3, 0.0, 0.1], 2.0), model.home, margin=0.1)
    assert found.solved
    assert (found.q >= model.limits.lower + 0.1).all()
    assert (found.q <= model.limits.upper - 0.1).all()


@pytest.mark.parametrize(
    ("pose", "message"),
    [
        (np.eye(4), "pose must be a pin.SE3, got ndarray"),
        (None, "got NoneType"),
        (pin.SE3(np.eye(3), np.array([np.nan, 0.0, 0.0])), "position of the pose must be finite"),
        (
            pin.SE3(2.0 * np.eye(3), np.zeros(3)),
            "rotation of the pose must be a 3 by 3 matrix of right-handed unit axes",
        ),
        (
            pin.SE3(np.diag([1.0, 1.0, -1.0]), np.zeros(3)),
            "rotation of the pose must be a 3 by 3 matrix of right-handed unit axes",
        ),
    ],
)
def test_an_invalid_pose_is_refused(model, ik, pose, message):
    with pytest.raises(MotionError, match=message) as raised:
        ik.solve(pose, model.home)
    assert raised.value.reason == "target"


@pytest.mark.parametrize("start", [np.zeros(6), np.full(7, np.nan), 3.0])
def test_an_invalid_configuration_is_refused(model, ik, start):
    with pytest.raises(MotionError, match="7 finite numbers"):
        ik.solve(model.pose(model.home), start)


def test_an_empty_list_of_poses_is_refused(model, ik):
    with pytest.raises(MotionError, match="no target pose"):
        ik.nearest([], model.home)


def test_other_arms_solve_reachable_poses(menagerie_arm, rng):
    model = menagerie_arm.make_model()
    ik = InverseKinematics(model)
    for q in random_configurations(model, rng, 100):
        T = model.pose(q)
        found = ik.solve(T, model.home)
        assert found.solved and model.limits.contain(found.q)
        assert max(error_in_mujoco(menagerie_arm, found.q, T)) <= 1.001e-6


def pointing_down_aside(model, rng, angle):
    """Give a pose pointing down, turned from what an arm of five joints reaches there [rad]."""
    q = model.home + rng.uniform(-2.0, 2.0) * np.eye(5)[0] + rng.uniform(-2.0, 2.0) * np.eye(5)[4]
    T = model.pose(q)
    outwards = T.translation * [1.0, 1.0, 0.0] / np.linalg.norm(T.translation[:2])
    return pin.SE3(pin.exp3(angle * outwards) @ T.rotation, T.translation)


def test_a_pose_that_rounded_numbers_keep_from_the_arm_is_within_its_tolerance(five_joints, rng):
    model = five_joints.make_model()
    ik = InverseKinematics(model)
    for _ in range(40):
        T = pointing_down_aside(model, rng, 2e-5)
        found = ik.solve(T, model.home)
        assert found.solved and found.residuals[0].met and found.reason == ""
        position, angle = error_in_mujoco(five_joints, found.q, T)
        assert position <= 1e-5 and angle <= 1e-4
        assert ik.follow(T, found.q).solved and ik.nearest(T, model.home).solved
        assert ik.solve(IKProblem(targets=PoseTarget("tool", T)), model.home).solved


def test_beyond_the_tolerance_a_pose_is_not_solved(five_joints, rng):
    model = five_joints.make_model()
    ik = InverseKinematics(model)
    for _ in range(5):
        T = pointing_down_aside(model, rng, 3e-4)
        found = ik.solve(T, model.home)
        assert not found.solved and not ik.follow(T, found.q).solved
        assert not ik.nearest(T, model.home).solved
    model.tolerance = Tolerance(position=1e-3, rotation=1e-3)
    assert InverseKinematics(model).solve(T, model.home).solved


def test_a_tolerance_of_a_target_replaces_that_of_the_arm(five_joints, rng):
    model = five_joints.make_model()
    T = pointing_down_aside(model, rng, 2e-5)
    exact = IKProblem(targets=PoseTarget("tool", T, tolerance=1e-6))
    assert not InverseKinematics(model).solve(exact, model.home).solved


def test_where_the_arm_reaches_a_pose_its_tolerance_is_not_used(model, rng):
    model.tolerance = Tolerance(position=1e-2, rotation=1e-2)
    ik = InverseKinematics(model)
    for q in random_configurations(model, rng, 40):
        found = ik.solve(model.pose(q), model.home)
        assert found.solved and max(found.position_error, found.rotation_error) <= 1e-6
