"""Ways around what is in the way: in the plane where one can see them, and in the arm's world."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.collision import FreeSpace
from bt_manip.exceptions import MotionError
from bt_manip.planning import (
    PlanningProblem,
    RRTConnect,
    discretize_segment,
    edge_is_free,
    shortcut,
    smooth_paths,
)
from bt_manip.robots import JointLimits

DT = 1e-3


def plane(free, start=(-1.0, 0.0), goals=((1.0, 0.0),), seed=0) -> PlanningProblem:
    """Two joints, each from -2 to 2 rad."""
    one = np.ones(2)
    limits = JointLimits(-2 * one, 2 * one, one, one, one, one)
    rng = np.random.default_rng(seed)
    return PlanningProblem(np.array(start), np.array(goals), free, limits, rng)


def beside_the_wall(q) -> bool:
    """A wall from below up to 1 rad."""
    return not (abs(q[0]) < 0.2 and q[1] < 1.0)


def test_it_finds_a_way_around_a_wall_for_every_seed():
    for seed in range(20):
        problem = plane(beside_the_wall, seed=seed)
        found = RRTConnect().plan(problem)
        assert found.reason == "" and found.samples > 0
        assert np.array_equal(found.path[0], problem.start)
        assert np.array_equal(found.path[-1], problem.goals[0])
        for a, b in zip(found.path, found.path[1:], strict=False):
            assert edge_is_free(a, b, beside_the_wall, 0.04)


def test_the_same_request_gives_the_same_answer():
    first, second = (RRTConnect().plan(plane(beside_the_wall, seed=5)) for _ in range(2))
    assert np.array_equal(first.path, second.path) and first.samples == second.samples


def test_of_several_goals_it_takes_one_that_can_be_reached():
    def free(q):  # the first goal is walled in
        return not 0.2 < np.abs(q - [1.0, 0.0]).max() < 0.4

    found = RRTConnect().plan(plane(free, goals=((1.0, 0.0), (0.0, 1.5))))
    assert np.array_equal(found.path[-1], [0.0, 1.5])


@pytest.mark.parametrize("seed", range(3))
def test_it_finds_the_way_out_of_a_narrow_place_along_joint_limits(seed):
    one = np.ones(4)
    limits = JointLimits(-2 * one, 2 * one, one, one, one, one)

    def free(q):  # up to 0.5 rad of the first joint all others have to stay near their limits
        return q[0] > 0.5 or (q[1:] > 1.8).all()

    start, goal = np.array([-1.9, 1.9, 1.9, 1.9]), np.array([1.9, -1.0, -1.0, -1.0])
    rng = np.random.default_rng(seed)
    found = RRTConnect().plan(PlanningProblem(start, goal[np.newaxis], free, limits, rng))
    assert found.reason == "" and np.array_equal(found.path[-1], goal)
    for a, b in zip(found.path, found.path[1:], strict=False):
        assert edge_is_free(a, b, free, 0.04)
    assert (found.path >= limits.lower).all() and (found.path <= limits.upper).all()


def test_it_gives_up_after_a_count_of_samples_and_says_so():
    found = RRTConnect(samples=50).plan(plane(lambda q: abs(q[0]) > 0.2))
    assert not len(found.path)
    assert found.samples == 50 and "50 samples" in found.reason


def test_shortening_cuts_detours_and_keeps_the_ends(rng):
    detour = np.array([[-1.0, 0.0], [-1.5, 1.8], [0.0, 1.9], [1.9, 1.9], [1.0, 0.0]])
    short = shortcut(detour, beside_the_wall, rng)
    assert np.array_equal(short[0], detour[0]) and np.array_equal(short[-1], detour[-1])

    def length(path):
        return np.linalg.norm(np.diff(path, axis=0), axis=1).sum()

    best = 0.4 + 2 * np.hypot(0.8, 1.0)  # around both corners of the wall
    assert best - 1e-9 <= length(short) <= 1.1 * best
    for a, b in zip(short, short[1:], strict=False):
        assert edge_is_free(a, b, beside_the_wall, 0.01)


def test_smooth_paths_keep_the_ends_and_come_nearer_to_the_corners():
    corner = np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]])
    heights = []
    for path in smooth_paths(corner):
        q, slope, bend = path.evaluate(np.linspace(0.0, 1.0, 500))
        assert np.allclose(q[[0, -1]], corner[[0, -1]], atol=1e-9)
        assert np.abs(np.diff(slope, axis=0)).max() < 0.5  # no corner is left
        assert np.abs(bend[[0, -1]]).max() < 1e-2  # and it is straight at its ends
        heights.append(q[:, 1].max())
    assert heights == sorted(heights) and 0.9 < heights[-1] < 1.0


def test_two_waypoints_are_a_straight_path():
    (path,) = smooth_paths(np.array([[0.0, 0.0], [1.0, 2.0]]))
    assert np.allclose(path.evaluate(np.array([0.25]), 0)[0], [[0.25, 0.5]])


def test_the_places_on_a_line_are_even_and_end_at_its_end():
    between = discretize_segment(np.zeros(2), np.array([0.1, -0.05]), 0.03)
    assert np.allclose(between[:, 0], [0.025, 0.05, 0.075, 0.1])


@pytest.fixture
def arm(walled) -> Arm:
    arm = Arm(walled.robot, ik=walled.ik, world=walled.world)
    arm.reset(walled.ik.solve(walled.left, arm.model.home).q)
    return arm


def driven(arm) -> np.ndarray:
    rows = [arm.q.copy()]
    while arm.moving:
        arm.advance(DT)
        rows.append(arm.q.copy())
    return np.array(rows)


@pytest.mark.parametrize("seed", range(5))
def test_the_arm_moves_around_the_wall_and_touches_nothing(walled, arm, seed):
    arm.move_to_pose(walled.right, rng=np.random.default_rng(seed))
    q = driven(arm)
    fine = np.vstack([discretize_segment(a, b, 2e-3) for a, b in zip(q, q[1:], strict=False)])
    assert not any(walled.world.collisions(x) for x in fine)
    T = arm.model.pose(arm.q)
    assert T.translation == pytest.approx(walled.right.translation, abs=1e-5)


@pytest.mark.parametrize("speed", [0.0, 0.02])  # [m/s]
def test_an_arm_that_follows_comes_around_the_wall_to_a_target_that_moves(walled, arm, speed):
    for tick in range(300):
        moved = np.array([speed * 10 * DT * tick, 0.0, 0.0])
        target = pin.SE3(walled.right.rotation, walled.right.translation + moved)
        arm.follow(target)
        for _ in range(10):
            arm.advance(DT)
            assert tick % 10 or not walled.world.collisions(arm.q)
    assert np.linalg.norm(arm.model.pose(arm.q).translation - target.translation) < 2e-3


def test_where_the_straight_line_is_free_it_is_driven_straight(walled, arm):
    start, target = arm.q.copy(), arm.q + [0.1, -0.1, 0.1, 0.0, 0.1, 0.0, 0.2]
    arm.move_to_configuration(target)
    way = (target - start) / np.linalg.norm(target - start)
    off = driven(arm) - start
    assert np.abs(off - np.outer(off @ way, way)).max() < 1e-12


@pytest.mark.parametrize(
    "ask",
    [
        lambda arm: arm.move_to_configuration(arm.model.home),
        lambda arm: arm.move_linear(spatial.pointing_down((0.5, 0.25, 0.3), 0.0)),
    ],
)
def test_a_start_too_deep_in_something_to_back_out_of_it_is_named(walled, arm, ask):
    deep = spatial.pointing_down((0.5, 0.25, -0.02), 0.0)
    arm.reset(walled.ik.solve(deep, arm.q).q)
    before = arm.get_state()
    with pytest.raises(MotionError, match=r"at the start 'panda/\w+' is \d+\.\d mm inside 'top'"):
        ask(arm)
    assert arm.get_state() == before


def test_a_target_inside_an_obstacle_is_refused_by_name_and_nothing_moves(walled, arm):
    inside = walled.ik.solve(walled.left, arm.q).q
    inside[1] += 0.3  # leans into the table
    before = arm.get_state()
    with pytest.raises(
        MotionError, match=r"the target is in collision: 'panda/\w+' would be .* 'top'"
    ):
        arm.move_to_configuration(inside)
    assert arm.get_state() == before


def test_a_line_through_the_wall_is_refused_with_how_far_it_gets(walled, arm):
    with pytest.raises(MotionError, match=r"blocked after \d+ % .* touch 'wall'") as raised:
        arm.move_linear(walled.right)
    assert raised.value.reason == "collision" and not arm.moving


def test_a_start_in_collision_is_backed_out_of(walled, arm):
    T = walled.left.copy()
    T.translation = np.array([0.5, 0.25, 0.008])  # the finger tips are 3 mm inside the table
    arm.reset(walled.ik.solve(T, arm.q).q)
    assert walled.world.collisions(arm.q)
    arm.move_to_pose(walled.left)
    q = driven(arm)
    deepest = [min((n.distance for n in walled.world.collisions(x)), default=0.0) for x in q]
    assert min(deepest) >= deepest[0] - 1e-4 and deepest[-1] == 0.0


def test_redirected_in_motion_it_does_not_turn_through_the_wall(walled, arm):
    arm.move_to_configuration(arm.q + [0.3, -0.3, 0.0, 0.0, 0.0, 0.0, 0.0])
    for _ in range(80):
        arm.advance(DT)
    assert np.abs(arm.v).max() > 0.1
    arm.move_to_pose(walled.right)
    q = driven(arm)
    assert not any(walled.world.collisions(x) for x in q)
    assert arm.model.pose(arm.q).translation == pytest.approx(walled.right.translation, abs=1e-5)


def test_when_there_is_no_way_it_says_what_is_in_it(walled, arm):
    class Helpless:
        def plan(self, problem):
            return RRTConnect(samples=1).plan(problem)

    with pytest.raises(
        MotionError, match="no collision-free path: .* would touch 'wall'; no path found with 1 sam"
    ):
        arm.move_to_pose(walled.right, planner=Helpless())
    assert not arm.moving


def test_the_planned_way_is_looked_at_with_everything_where_it_is_now(walled, arm):
    space = FreeSpace(walled.world, arm.q)
    assert space.is_free(arm.q)


def test_joints_that_go_around_more_than_once_are_searched_near_start_and_goals():
    one = np.ones(3)
    far = np.array([1.0, 2 * np.pi, np.inf])
    limits = JointLimits(-far, far, one, one, one, one)
    start, goals = np.array([0.0, 0.5, 0.0]), np.array([[0.5, -5.0, 1.0]])
    problem = PlanningProblem(start, goals, lambda q: True, limits, np.random.default_rng(0))
    lower, upper = problem.bounds()
    assert lower == pytest.approx([-1.0, -2 * np.pi, -np.pi])
    assert upper == pytest.approx([1.0, 0.5 + np.pi, 1.0 + np.pi])
