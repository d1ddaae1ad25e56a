"""Inverse kinematics; the oracle is forward kinematics, MuJoCo's where a solution is judged."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import IKProblem, InverseKinematics, PoseTarget, PositionTarget
from bt_manip.robots import Tolerance
from tests.measuring.kinematics import (
    error_in_mujoco,
    frame_pose,
    position_error,
    random_configurations,
    refused,
)
from tests.robot_fixtures import menagerie_robot

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)
GRIP = PoseTarget("tool", DOWN)


RESTARTS = "restarts must be an integer of at least 0, got "
GENERATOR = "rng must be a numpy.random.Generator, got "
MARGIN = "margin must be at least 0 .rad., got "
STEP = "max_step must be above 0 .rad., got "
TOLERANCE = "tolerance must be above 0 .m, rad., got "


@pytest.mark.parametrize(
    ("method", "asked", "message"),
    [
        ("solve", {"restarts": -1}, RESTARTS + "-1"),
        ("solve", {"rng": 0}, GENERATOR + "0"),
        ("solutions", {"restarts": -1}, RESTARTS + "-1"),
        ("solutions", {"rng": "seed"}, GENERATOR + "'seed'"),
        ("solutions", {"margin": np.nan}, MARGIN + "nan"),
        ("follow", {"max_step": np.full(7, 0.2)}, STEP + "array"),
        ("follow", {"margin": np.full(7, 0.1)}, MARGIN + "array"),
        ("follow", {"tolerance": (1e-3, 1e-3)}, TOLERANCE),
        ("follow", {"retry": "no"}, "retry must be True or False, got 'no'"),
    ],
)
def test_invalid_arguments_are_refused(model, ik, method, asked, message):
    for target in (DOWN, IKProblem(targets=GRIP)):
        refused(lambda target=target: getattr(ik, method)(target, model.home, **asked), message)


@pytest.mark.parametrize(
    ("request_", "start", "message"),
    [
        (np.eye(4), np.zeros(7), "pose must be a pin.SE3, got ndarray"),
        (PoseTarget("tool", DOWN, weight=1.0), np.zeros(7), "the target of frame 'tool' is a cost"),
        (DOWN, np.zeros(6), "configuration must be 7 finite numbers"),
    ],
)
def test_invalid_requests_and_configurations_are_refused(robot, ik, request_, start, message):
    for ask in (ik.solve, ik.follow, ik.solutions, ik.nearest):
        refused(lambda ask=ask: ask(request_, start), message)
    refused(lambda: ik.nearest([], ik.model.home), "no target pose")
    needed = "model must be a RobotModel .Robot.make_model., got Robot"
    refused(lambda: InverseKinematics(robot), needed)


def test_a_margin_or_a_tolerance_beside_a_problem_is_refused(model, ik):
    problem = IKProblem(targets=GRIP)
    own = "a problem has its own margin: ask for IKProblem.margin=....*got margin=0.1"
    refused(lambda: ik.follow(problem, model.home, margin=0.1), own)
    refused(lambda: ik.solutions(problem, model.home, margin=0.1), own)
    each = "each target of a problem has its own tolerance: ask for PoseTarget"
    refused(lambda: ik.follow(problem, model.home, tolerance=1e-3), each)


def test_a_target_alone_is_a_problem_with_a_margin_of_the_call(model, ik):
    of_problem = ik.follow(IKProblem(targets=GRIP, margin=0.1), model.home, max_step=1.0)
    of_target = ik.follow(GRIP, model.home, margin=0.1, max_step=1)  # an integer serves, too
    assert np.array_equal(of_target.q, of_problem.q)
    listed = ik.solutions([GRIP, DOWN], model.home, margin=0.1)
    assert {result.target for result in listed} <= {0, 1}
    assert np.abs(listed[0].q - ik.solutions(DOWN, model.home, margin=0.1)[0].q).max() < 1e-3


def test_nearest_keeps_a_margin_where_that_is_possible_and_ignores_one_that_leaves_no_range(
    model, ik
):
    kept = ik.nearest(spatial.pointing_down([0.3, 0.0, 0.1], 2.0), model.home, margin=0.1)
    assert kept.solved and model.limits.contain(kept.q, -0.1)
    for margin in (-0.1, np.nan, "wide"):
        refused(lambda margin=margin: ik.nearest(DOWN, model.home, margin=margin), "margin must be")
    found = ik.nearest(DOWN, model.home, margin=3.0)
    assert np.array_equal(found.q, ik.nearest(DOWN, model.home).q)
    assert ik.solutions(DOWN, model.home, margin=3.0) == []


def test_solutions_are_distinct_and_the_nearest_or_cheapest_comes_first(
    robot, model, ik, goal, rng
):
    q0, elbow = random_configurations(model, rng, 1)[0], PositionTarget("link4", [0, 0.4, 0.6])
    T = model.pose(goal).copy()
    costly = IKProblem(targets=[PoseTarget("tool", T), replace(elbow, weight=1.0)])
    for request, T_wt in ((DOWN, DOWN), (costly, T)):
        found = ik.solutions(request, q0, restarts=30, rng=rng)
        times = [(each.q - q0) / model.limits.velocity for each in found]
        distances = np.sqrt(np.mean(np.square(times), axis=1)).tolist()
        assert [ik.distance(each.q, q0) for each in found] == pytest.approx(distances)
        order = [each.cost for each in found] if request is costly else distances
        assert request is costly or {each.cost for each in found} == {0.0}
        assert len(found) >= 2 and order == sorted(order)
        for i, solution in enumerate(found):
            assert solution.solved
            assert max(error_in_mujoco(robot, solution.q, T_wt)) <= 1.001e-6
            assert all(np.abs(solution.q - other.q).max() > 0.1 for other in found[:i])
    for q0 in (model.limits.lower, model.limits.upper):
        inside = ik.solutions(DOWN, q0, restarts=30, margin=0.4)
        assert inside and all(model.limits.contain(each.q, -0.4) for each in inside)


def test_of_several_targets_that_of_the_nearest_solution_is_chosen(model, ik):
    yaws = (0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi)
    poses = [spatial.pointing_down([0.4, 0.0, 0.3], yaw) for yaw in yaws]
    turned = model.pose(model.home) * pin.SE3(pin.exp3(np.array([0.0, 0.0, 1.0])), np.zeros(3))
    for targets in (poses, [turned, PoseTarget("tool", turned, free_axis="z")], [turned]):
        found = ik.nearest(targets, model.home)
        alone = [ik.distance(ik.nearest(one, model.home).q, model.home) for one in targets]
        assert found.target == int(np.argmin(alone))
        assert ik.distance(found.q, model.home) <= min(alone) + 1e-9


def test_the_same_request_gives_the_same_bits_whatever_was_asked_before(model, ik, goal):
    elbow = frame_pose(model, goal, "link4").translation
    tool = PositionTarget("tool", model.pose(goal).translation)
    for target in (model.pose(goal), IKProblem(targets=[PositionTarget("link4", elbow), tool])):
        results = []
        for other in (ik, ik, InverseKinematics(model)):
            results.append(other.solve(target, model.home, rng=np.random.default_rng(5)))
            ik.solve(DOWN, model.home)
        assert len({(result.q.tobytes(), result.iterations) for result in results}) == 1


@pytest.mark.parametrize("arm", ["panda", "ur5e", "rail"])
def test_every_reachable_pose_is_solved_within_limits_whatever_the_tolerance(
    request, menagerie, rng, arm
):
    fixture = {"panda": "robot", "rail": "rail_robot"}.get(arm)
    robot = request.getfixturevalue(fixture) if fixture else menagerie_robot(menagerie, arm)
    model = robot.make_model()
    model.tolerance = Tolerance(position=1e-2, rotation=1e-2)
    ik = InverseKinematics(model)
    for q, q0 in zip(*random_configurations(model, rng, 60).reshape(2, 30, -1), strict=True):
        T = model.pose(q)
        for start in (model.home, q0):
            found = ik.solve(T, start)
            assert found.solved and found.reason == "" and model.limits.contain(found.q)
            assert max(error_in_mujoco(robot, found.q, T)) <= 1.001e-6


def test_nearest_first_yields_the_solutions_from_near_to_far(model, ik, rng):
    for q0 in random_configurations(model, rng, 5):
        poses = [spatial.pointing_down([0.45, 0.1, 0.3], yaw) for yaw in (0.4, 0.4 + 0.5 * np.pi)]
        listed = ik.solutions(poses, q0)
        yielded = list(ik.nearest_first(poses, q0))
        for one in listed:
            assert min(np.abs(one.q - other.q).max() for other in yielded) <= 0.1
        nearest = next(ik.nearest_first(poses, q0))
        assert np.array_equal(nearest.q, yielded[0].q)
        assert ik.distance(nearest.q, q0) <= 1.1 * ik.distance(listed[0].q, q0)


def test_the_nearest_solution_is_usually_nearer_than_those_from_random_guesses(model, ik, rng):
    nearer = 0
    for _ in range(10):
        q, q0 = random_configurations(model, rng, 2)
        T = model.pose(q)
        nearest = ik.distance(ik.nearest(T, q0).q, q0)
        others = [ik.solve(T, start).q for start in random_configurations(model, rng, 20)]
        nearer += nearest <= min(ik.distance(other, q0) for other in (q, *others)) + 1e-3
    assert nearer >= 9


def test_an_arm_of_six_joints_solves_problems(menagerie, rng):
    model = menagerie_robot(menagerie, "ur5e").make_model()
    ik = InverseKinematics(model)
    for q in rng.uniform(-2.5, 2.5, (4, 6)):
        T = model.pose(q)
        position = PositionTarget(ik.tool, T.translation)
        elbow = PositionTarget("forearm_link", [0.0, 0.0, 0.9], weight=1.0)
        found = ik.solve(IKProblem(targets=[position, elbow], manipulability=0.1), model.home)
        assert found.solved
        assert position_error(model, found.q, ik.tool, T.translation) <= 1e-6
        posed = IKProblem(targets=PoseTarget(ik.tool, T), posture=model.home)
        assert ik.solve(posed, model.home).solved


def pointing_down_aside(model, rng, angle):
    """Give a pose pointing down, turned from what an arm of five joints reaches there [rad]."""
    q = model.home + rng.uniform(-2.0, 2.0) * np.eye(5)[0] + rng.uniform(-2.0, 2.0) * np.eye(5)[4]
    T = model.pose(q)
    outwards = T.translation * [1.0, 1.0, 0.0] / np.linalg.norm(T.translation[:2])
    return pin.SE3(pin.exp3(angle * outwards) @ T.rotation, T.translation)


def test_a_pose_that_rounded_numbers_keep_from_the_arm_is_within_its_tolerance(five_joints, rng):
    model = five_joints.make_model()
    ik = InverseKinematics(model)
    for _ in range(15):
        T = pointing_down_aside(model, rng, 2e-5)
        found = ik.solve(T, model.home)
        assert found.solved and found.residuals[0].met and found.reason == ""
        position, angle = error_in_mujoco(five_joints, found.q, T)
        assert position <= 1e-5 and angle <= 1e-4
        assert ik.follow(T, found.q).solved and ik.nearest(T, model.home).solved
        assert ik.solve(PoseTarget("tool", T), model.home).solved
    exact = PoseTarget("tool", T, tolerance=1e-6)  # instead of that of the arm
    assert not ik.solve(exact, model.home).solved


def test_beyond_the_tolerance_a_pose_is_not_solved(five_joints, rng):
    model = five_joints.make_model()
    ik = InverseKinematics(model)
    for _ in range(2):
        T = pointing_down_aside(model, rng, 3e-4)
        found = ik.solve(T, model.home)
        assert not found.solved and not ik.follow(T, found.q).solved
        assert not ik.nearest(T, model.home).solved
    model.tolerance = Tolerance(position=1e-3, rotation=1e-3)
    assert InverseKinematics(model).solve(T, model.home).solved


@pytest.fixture(params=["panda", "five_joints"])
def any_robot(request):
    return request.getfixturevalue({"panda": "robot"}.get(request.param, request.param))


@pytest.mark.parametrize(
    ("axis", "pivot", "cone"),
    [
        ("z", (0.0, 0.0, 0.0), 0.0),
        ("z", (0.02, 0.0, 0.1), 0.0),
        ("x", (0.0, 0.03, 0.05), 0.0),
        ("z", (0.0, 0.0, 0.0), 0.3),
        ("x", (0.0, 0.0, 0.0), np.pi),
    ],
)
def test_the_arm_chooses_the_rotation_about_a_free_axis_through_a_pivot_and_a_tilt_inside_a_cone(
    any_robot, rng, axis, pivot, cone
):
    # Every pose is one of the arm, turned about the axis and tilted within the cone.
    ik, pivot = InverseKinematics(any_robot.make_model()), np.array(pivot)
    along = np.eye(3)["xyz".index(axis)]
    middle, turns, tilts = pin.SE3(np.eye(3), pivot), [], []
    for q in random_configurations(ik.model, rng, 15):
        tilt = np.cross(along, rng.normal(size=3))
        tilt *= min(0.9 * cone, 2.8) / np.linalg.norm(tilt)
        turn = pin.exp3(tilt) @ pin.exp3(rng.uniform(-3.0, 3.0) * along)
        T = ik.model.pose(q) * middle * pin.SE3(turn, np.zeros(3)) * middle.inverse()
        target = PoseTarget(ik.tool, T, free_axis=axis, cone=cone, pivot=pivot)
        found = ik.solve(target, ik.model.home)
        assert found.solved
        any_robot.set_configuration(found.q)
        mujoco.mj_kinematics(any_robot.mj_model, any_robot.mj_data)
        reached = any_robot.tool_pose
        distance = np.linalg.norm(reached.act(pivot) - T.act(pivot))
        cosine = (reached.rotation @ along) @ (T.rotation @ along)
        tilts.append(np.arccos(np.clip(cosine, -1.0, 1.0)))
        turns.append(np.linalg.norm(pin.log3(reached.rotation.T @ T.rotation)))
        assert distance <= 1e-5 and tilts[-1] <= cone + 1e-4
        assert found.position_error == pytest.approx(distance, abs=1e-9)
        if cone == np.pi:  # as where only the position is asked for
            anyhow = ik.solve(PositionTarget(ik.tool, T.translation), ik.model.home)
            assert anyhow.solved and error_in_mujoco(any_robot, anyhow.q, T)[0] <= 1e-5
    assert np.median(turns) > 0.1 and (np.max(tilts) > 0.01) == (cone > 0.0)


def test_an_arm_on_a_rail_chooses_rotations_and_names_margins_in_metres(rail_robot, rng):
    ik = InverseKinematics(rail_robot.make_model())
    for q in random_configurations(ik.model, rng, 10):
        T = ik.model.pose(q)
        assert ik.solve(PoseTarget(ik.tool, T, free_axis="z"), ik.model.home).solved
    with pytest.raises(MotionError, match=r"a margin of 0.7 m leaves .*rail no range"):
        ik.solve(IKProblem(targets=PoseTarget("tool", T), margin=0.7), ik.model.home)


def test_what_is_out_of_reach_keeps_the_margin_from_both_limits(ik):
    limits, away = ik.model.limits, PoseTarget("tool", spatial.pointing_down([3.0, 0.0, 0.5]))
    for q0 in (limits.lower, limits.upper):
        result = ik.solve(IKProblem(targets=away, margin=0.2), q0)
        q = result.q
        assert "m out of reach" in result.reason
        assert np.all(q >= limits.lower + 0.2 - 1e-9) and np.all(q <= limits.upper - 0.2 + 1e-9)
