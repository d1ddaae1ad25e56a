"""The limit of the tool's speed in every motion, judged by MuJoCo's positions of the tool."""

from dataclasses import replace
from math import inf, nan

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import load_plugins
from bt_manip.arm import Arm
from bt_manip.exceptions import BtManipError, MotionError
from bt_manip.robots import panda
from bt_manip.runner import RunObserver, RunRequest, prepare, request_of
from bt_manip.runner.commanded_robot import chosen_robots, make_robot
from bt_manip.scenes import Scene, SceneRobot
from bt_manip.trajectories import time_parameterize_segment
from tests.measuring.random_arms import random_arm
from tests.measuring.tool_speeds import STEP, ToolPositions

from .watch import arm_of

LIMIT = 0.25  # [m/s]
SLOW = replace(panda(), tool_speed=LIMIT)


@pytest.fixture(scope="module")
def tool() -> ToolPositions:
    return ToolPositions(SLOW)


@pytest.fixture(scope="module")
def built() -> Arm:
    return arm_of(SLOW)


@pytest.fixture
def arm(built) -> Arm:
    built.reset()
    return built


@pytest.fixture
def goal(arm) -> np.ndarray:
    return arm.model.home + np.array([1.2, 0.5, 0.3, 0.6, 0.2, 0.4, 0.1])


def advance(arm, duration=60.0):
    """Advance by a time [s], at most to rest; return the configurations."""
    rows = [arm.q_ref]
    while arm.moving and len(rows) * STEP < duration:
        arm.advance(STEP)
        rows.append(arm.q_ref)
    return np.array(rows)


def test_pick_and_place_with_blends_keeps_it(tool):
    class Rows(RunObserver):
        def run_started(self, run):
            self.arm, self.reference, self.simulated = run.station.arm, [], []

        def after_step(self):
            self.reference.append(self.arm.q_ref)
            self.simulated.append(self.arm.robot.tool_pose.translation)

        def cycle_ended(self, status, reason):
            self.status = status

    parts, rows = load_plugins().parts, Rows()
    request = request_of("pick_place", parts, tool_speed=LIMIT, settings={"blend_radius": "0.35"})
    prepare(request, parts).execute([rows])
    assert rows.status == "SUCCESS"
    assert tool.speed(rows.reference) <= LIMIT
    simulated = np.linalg.norm(np.diff(rows.simulated, axis=0), axis=1) / STEP
    assert 0.9 * LIMIT < simulated.max() <= 1.01 * LIMIT


def test_the_limit_for_lines_does_not_limit_other_motions(goal, tool):
    lines = arm_of(replace(panda(), tool_limits=replace(panda().tool_limits, velocity=LIMIT)))
    lines.move_to_configuration(goal)
    assert tool.speed(advance(lines)) > 2.0 * LIMIT


def test_it_is_kept_at_a_lower_speed_without_making_it_slower_still(arm, goal, tool):
    free = replace(arm.model.limits, tool_speed=inf)
    duration = time_parameterize_segment(arm.q_ref, goal, arm.model.with_limits(free)).duration
    arm.speed_scale = 0.05
    arm.move_to_configuration(goal)
    assert arm.remaining == pytest.approx(20.0 * duration, rel=1e-3)
    arm.speed_scale = 1.0
    assert 0.9 * LIMIT < tool.speed(advance(arm)) <= LIMIT


def test_a_lower_limit_slows_a_running_motion_on_its_path(arm, goal, tool):
    arm.move_to_configuration(goal)
    advance(arm, 1.0)
    arm.tool_speed = 0.1
    assert not arm.follower.stopping
    slowing, slow = advance(arm, 0.2), advance(arm)
    assert tool.speed(slowing) <= LIMIT
    assert 0.08 < tool.speed(slow) <= 0.1
    np.testing.assert_allclose(slow[-1], goal)
    arm.move_to_configuration(goal - 0.2)
    assert 0.08 < tool.speed(advance(arm)) <= 0.1


@pytest.mark.parametrize("seed", [11, 47])
def test_a_limit_just_below_a_short_peak_of_the_speed_is_kept_by_the_paused_motion(seed):
    robot, rng = random_arm(seed), np.random.default_rng(seed)
    arm, tool = Arm(robot), ToolPositions(robot)
    lower, upper = robot.limits.sampling_bounds()
    start = 0.9 * rng.uniform(lower, upper)
    goal = np.clip(start + rng.uniform(-0.03, 0.03, len(start)), lower, upper)
    arm.reset(start)
    arm.move_to_configuration(goal)
    peak = tool.speed(advance(arm))
    arm.reset(start)
    arm.pause()
    arm.move_to_configuration(goal)
    arm.tool_speed = peak / 1.015
    arm.resume()
    assert 0.9 < tool.speed(advance(arm)) / arm.tool_speed <= 1.0


def test_a_motion_stopped_while_it_is_too_fast_stops_on_its_path(arm, goal, tool):
    arm.move_to_configuration(goal)
    advance(arm, 1.0)
    before = tool.speed(advance(arm, 0.01))
    arm.tool_speed = 0.02
    arm.stop()
    assert arm.remaining < 0.5
    assert tool.speed(advance(arm)) <= 1.01 * before


def test_a_request_while_it_is_too_fast_ends_within_the_new_limit(arm, goal, tool):
    arm.move_to_configuration(goal)
    assert tool.speed(advance(arm, 0.4)) > 0.2
    arm.tool_speed = 0.05
    arm.move_to_configuration(arm.q_ref - 0.05)
    assert tool.speed(advance(arm, 0.5)) <= LIMIT
    assert 0.0 < tool.speed(advance(arm)) <= 0.05


def test_a_redirected_arm_turns_more_slowly_where_its_tool_would_be_too_fast(arm, goal, tool):
    arm.move_to_configuration(goal)
    advance(arm, 0.6)
    arm.move_to_configuration(arm.q_ref + [-0.5, 0.1, 0.2, -0.1, 0.0, 0.1, 0.3])
    assert arm.trajectory.get_state()["kind"] == "joints"  # it does not stop first
    assert 0.8 * LIMIT < tool.speed(advance(arm)) <= LIMIT


def test_a_raised_limit_leaves_a_running_motion_as_it_is(arm, goal, tool):
    arm.tool_speed = 0.1
    arm.move_to_configuration(goal)
    advance(arm, 1.0)
    arm.tool_speed = inf
    assert arm.tool_speed == LIMIT  # that of the robot
    assert tool.speed(advance(arm)) <= 0.1


def test_it_is_positive_restored_and_reset(arm):
    for speed in (0.0, nan):
        with pytest.raises(MotionError, match="tool's speed must be positive"):
            arm.tool_speed = speed
    assert arm.tool_speed == LIMIT
    assert "tool_speed" not in arm.get_state()
    arm.tool_speed = 0.1
    state = arm.get_state()
    arm.reset()
    assert arm.tool_speed == LIMIT
    arm.set_state(state)
    assert arm.tool_speed == 0.1


@pytest.mark.parametrize(
    ("of_request", "of_scene", "limit"),
    [(None, None, LIMIT), (None, 0.5, 0.5), (0.1, 0.5, 0.1), (inf, 0.5, inf)],
)
def test_the_request_goes_before_the_scene_and_the_scene_before_the_description(
    parts, of_request, of_scene, limit
):
    scene = Scene((SceneRobot(pin.SE3.Identity(), tool_speed=of_scene),))
    (chosen,) = chosen_robots(RunRequest(robot=SLOW, tool_speed=of_request), scene, parts)
    assert make_robot(chosen, parts).limits.tool_speed == limit


def test_a_request_with_a_limit_that_is_not_positive_is_refused():
    with pytest.raises(BtManipError, match="tool speed must be positive"):
        RunRequest(tool_speed=0.0)


def test_a_target_that_is_too_fast_is_followed_nearly_as_fast_as_the_limit_allows(arm, tool):
    v, q, rows = np.eye(7)[0], arm.model.home, []
    for _ in range(20):
        q = q + 0.05 * v
        arm.servo(q, v, 0.05)
        rows.extend(advance(arm, 0.05)[1:])
    assert 0.8 < tool.speed(np.array(rows)) / LIMIT <= 1.0
