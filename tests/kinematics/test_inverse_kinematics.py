"""The oracle is forward kinematics: MuJoCo's where a solution is judged."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import IKProblem, InverseKinematics, PositionTarget
from bt_manip.kinematics.initial_guesses import InitialGuesses
from bt_manip.kinematics.levenberg_marquardt import levenberg_marquardt
from bt_manip.robots import Robot, RobotDescription, compile_alone


def error_in_mujoco(robot, q, T):
    """Distance [m] and angle [rad] between the simulated tool and a pose."""
    robot.set_configuration(q)
    mujoco.mj_kinematics(robot.mj_model, robot.mj_data)
    found = robot.tool_pose
    angle = np.linalg.norm(pin.log3(found.rotation.T @ T.rotation))
    return np.linalg.norm(found.translation - T.translation), angle


def random_configurations(model, rng, n):
    return rng.uniform(model.limits.lower, model.limits.upper, (n, model.nq))


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


def test_what_was_asked_before_does_not_change_the_answer(model, ik, rng):
    q, other, q0 = random_configurations(model, rng, 3)
    first = ik.solve(model.pose(q), q0)
    ik.solve(model.pose(other), other)
    assert np.array_equal(ik.solve(model.pose(q), q0).q, first.q)


def test_a_pose_beyond_the_reach_is_refused_without_a_search(model, ik):
    found = ik.solve(spatial.pointing_down([2.0, 0.0, 0.3]), model.home)
    assert not found.solved and found.iterations == 0
    assert "m out of reach" in found.reason
    assert found.position_error == pytest.approx(1.7, abs=0.02)


def test_no_configuration_reaches_farther_than_the_reach(model, ik, rng):
    farthest = 0.0
    for q in random_configurations(model, rng, 3000):
        assert ik.solve(model.pose(q), q, restarts=0).solved
        farthest = max(farthest, ik._reach.distance_at(q))
    assert 0.97 * ik._reach.distance < farthest <= ik._reach.distance + 1e-9


def test_a_pose_that_the_limits_forbid_ends_at_the_bound(model):
    ik = InverseKinematics(model, restarts=5)
    inside_the_base = spatial.pointing_down([0.0, 0.0, 0.05])
    found = ik.solve(inside_the_base, model.home)
    assert not found.solved and found.restarts == 5
    assert found.reason == "no solution from 6 initial guesses"
    assert model.limits.contain(found.q)


def test_a_search_in_vain_begins_no_other_start_after_so_many_steps(model):
    ik = InverseKinematics(model, max_failed_iterations=100)
    found = ik.solve(spatial.pointing_down([0.0, 0.0, 0.05]), model.home)
    assert not found.solved and found.restarts < ik.restarts
    assert 100 <= found.iterations < 100 + ik.iterations


def test_a_descent_to_no_solution_ends_sooner_where_its_steps_have_to_promise_something(model, ik):
    in_vain, near = spatial.pointing_down([0.0, 0.0, 0.05]), model.pose(model.home + 0.1)

    def descent(T, min_decrease):
        task = ik._compile(T, model.home)
        limits = task.lower, task.upper
        return levenberg_marquardt(
            task.constraints, model.home, *limits, iterations=50, min_decrease=min_decrease
        )

    assert not descent(in_vain, 0.2).solved and not descent(in_vain, 0.0).solved
    assert 1 <= descent(in_vain, 0.2).iterations < descent(in_vain, 0.0).iterations
    assert np.array_equal(descent(near, 0.2).q, descent(near, 0.0).q) and descent(near, 0.2).solved


def test_starts_that_lie_within_rounding_of_each_other_are_all_given(model, ik):
    room = model.limits.upper - model.limits.lower
    fixed = IKProblem(targets=PositionTarget("tool", np.ones(3)), margin=(0.5 - 1e-15) * room)
    assert len(list(ik._initial_guesses.spread(ik._compile(fixed, model.home), 400))) == 400


def test_searches_start_again_far_from_where_they_started_before(model, ik, rng):
    starts = InitialGuesses(model, 2000, np.random.default_rng(0))
    task = ik._compile(model.pose(rng.uniform(model.limits.lower, model.limits.upper)), model.home)
    given = np.array(list(starts.spread(task, 90)))
    assert len(np.unique(given, axis=0)) == 90
    assert np.array_equal(given[0], starts.nearest(task, 1)[0])
    apart = [np.sqrt(((q - given[:i]) ** 2).mean(axis=1)).min() for i, q in enumerate(given) if i]
    assert min(apart[:5]) > 1.0 and min(apart) > 0.3


def test_following_never_steps_far(model, ik, rng):
    limits = model.limits
    for q in random_configurations(model, rng, 300):
        near = np.clip(q + rng.uniform(-0.1, 0.1, 7), limits.lower, limits.upper)
        found = ik.follow(model.pose(near), q)
        assert found.solved
        assert np.abs(found.q - q).max() <= 0.2 + 1e-12
        assert limits.contain(found.q)


def test_following_says_that_a_joint_would_have_to_jump(model, ik):
    found = ik.follow(spatial.pointing_down([0.3, 0.5, 0.3], 2.0), model.home)
    assert not found.solved
    assert "jump" in found.reason


def test_following_names_the_joint_at_its_limit(model, ik):
    q = np.array(model.home)
    q[6] = model.limits.upper[6]
    turned = model.pose(q) * pin.SE3(pin.exp3(np.array([0.0, 0.0, 0.1])), np.zeros(3))
    found = ik.follow(turned, q, max_step=0.05)
    assert not found.solved
    assert "joint7 at the limit" in found.reason


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


def test_the_nearest_solution_is_mostly_nearer_than_what_random_starts_find(model, ik, rng):
    nearer = 0
    for _ in range(20):
        q, q0 = random_configurations(model, rng, 2)
        T = model.pose(q)
        nearest = ik.distance(ik.nearest(T, q0).q, q0)
        others = [ik.solve(T, start).q for start in random_configurations(model, rng, 20)]
        nearer += nearest <= min(ik.distance(other, q0) for other in (q, *others)) + 1e-3
    assert nearer >= 18


def test_a_solution_cannot_be_moved_nearer_along_its_self_motion(model, ik, rng):
    q0 = model.home + rng.uniform(-0.3, 0.3, 7)
    found = ik.nearest(spatial.pointing_down([0.4, 0.2, 0.4], 0.5), q0).q
    weight = model.limits.velocity**2
    *_, rows = np.linalg.svd(model.jacobian(found))
    self_motion = rows[6]
    # The gradient of the weighted squared distance has no part along the self-motion.
    slope = (found - q0) / weight @ self_motion / np.linalg.norm((found - q0) / weight)
    assert abs(slope) < 0.02


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
def test_what_is_not_a_pose_is_refused(model, ik, pose, message):
    with pytest.raises(MotionError, match=message) as raised:
        ik.solve(pose, model.home)
    assert raised.value.reason == "target"


@pytest.mark.parametrize("start", [np.zeros(6), np.full(7, np.nan), 3.0])
def test_what_is_not_a_configuration_is_refused(model, ik, start):
    with pytest.raises(MotionError, match="7 finite numbers"):
        ik.solve(model.pose(model.home), start)


def test_no_pose_at_all_is_refused(model, ik):
    with pytest.raises(MotionError, match="no target pose"):
        ik.nearest([], model.home)


@pytest.mark.parametrize(
    ("folder", "file", "joints", "site"),
    [
        ("universal_robots_ur5e", "ur5e.xml", "{}_joint", "attachment_site"),
        ("kuka_iiwa_14", "iiwa14.xml", "joint{}", "attachment_site"),
        ("franka_fr3", "fr3.xml", "fr3_joint{}", "attachment_site"),
        ("ufactory_xarm7", "xarm7.xml", "joint{}", "link_tcp"),
    ],
)
def test_other_arms_reach_what_they_can(menagerie, rng, folder, file, joints, site):
    ur = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    names = tuple(joints.format(i) for i in (ur if "ur5e" in file else range(1, 8)))
    n = len(names)
    robot = Robot(
        RobotDescription(
            name="other",
            model=str(menagerie / folder / file),
            arm_joints=names,
            tool_frame=site,
            home=(0.0,) * n,
            velocity=(2.0,) * n,
            acceleration=(5.0,) * n,
            jerk=(1000.0,) * n,
            effort=(50.0,) * n,
        )
    )
    compile_alone(robot)
    model = robot.make_model()
    ik = InverseKinematics(model)
    for q in random_configurations(model, rng, 100):
        T = model.pose(q)
        found = ik.solve(T, model.home)
        assert found.solved and model.limits.contain(found.q)
        assert max(error_in_mujoco(robot, found.q, T)) <= 1.001e-6
