"""Time scaling, pause and stop: a motion changes its speed and stays on its path."""

import json

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError

from .test_arm import DT, Watch

GOAL = np.array([0.9, 0.3, -0.4, -1.9, 0.5, 1.9, -0.3])


@pytest.fixture
def watch(arm):
    return Watch(arm)


def path_of(arm, ask) -> np.ndarray:
    """Return the configurations of a requested motion at full speed, made by a copy of the arm."""
    other = Arm(arm.robot, ik=arm.ik)
    other.set_state(arm.get_state())
    ask(other)
    watched = Watch(other)
    watched.run()
    return np.array([row[0] for row in watched.rows])


def distance_from_path(watch, path: np.ndarray) -> float:
    """Return the greatest distance of the configurations from a finely sampled path [rad]."""
    worst = 0.0
    for q, *_ in watch.rows:
        i = int(np.abs(path - q).max(axis=1).argmin())
        near = path[max(0, i - 1) : i + 2]
        for a, b in zip(near, near[1:], strict=False):
            along = b - a
            part = np.clip((q - a) @ along / max(along @ along, 1e-30), 0.0, 1.0)
            near = np.vstack([near, a + part * along])
        worst = max(worst, float(np.abs(near - q).max(axis=1).min()))
    return worst


def joints(arm):
    arm.move_to_configuration(GOAL)


def straight(arm):
    arm.move_linear(spatial.pointing_down([0.45, 0.25, 0.3], 0.0))


@pytest.mark.parametrize("ask", [joints, straight])
def test_paused_arm_rests_on_its_path_and_arrives_when_resumed(arm, watch, ask):
    path = path_of(arm, ask)
    ask(arm)
    target = arm.target
    watch.run(250)
    arm.pause()
    watch.run()
    assert arm.paused and arm.busy and not arm.moving and not arm.v.any()
    watch.run(100)
    arm.resume()
    assert not arm.paused and arm.moving
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, target) and not arm.busy
    assert distance_from_path(watch, path) < 1e-4


def test_half_speed_scale_doubles_the_remaining_time(arm, watch):
    joints(arm)
    watch.run(200)
    remaining = arm.remaining
    arm.speed_scale = 0.5
    watch.check()
    assert arm.remaining == pytest.approx(2 * remaining, rel=0.15)
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


def test_speed_scale_applies_to_later_motions_too(arm, watch):
    joints(arm)
    full = arm.remaining
    arm.reset()
    arm.speed_scale = 0.25
    joints(arm)
    assert arm.remaining == pytest.approx(4 * full)
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


def test_motion_requested_at_speed_scale_zero_is_paused(arm, watch):
    arm.speed_scale = 0.0
    joints(arm)
    assert arm.paused and not arm.moving
    arm.speed_scale = 1.0
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


def test_changes_at_random_times_stay_within_limits_and_on_the_path(arm, watch, rng):
    path = path_of(arm, joints)
    joints(arm)
    for _ in range(30):
        watch.run(int(rng.integers(1, 120)))
        if not arm.busy:
            break
        arm.speed_scale = float(rng.choice([0.0, 0.1, 0.4, 0.7, 1.0]))
    arm.resume()
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)
    assert distance_from_path(watch, path) < 1e-4
    assert watch.worst_effort() <= 0.9501


def test_stop_discards_a_paused_motion(arm, watch):
    joints(arm)
    watch.run(200)
    arm.pause()
    watch.run()
    arm.stop()
    arm.resume()
    assert not arm.busy


def test_stop_at_a_lower_speed_scale_stays_on_the_path(arm, watch):
    path = path_of(arm, joints)
    arm.speed_scale = 0.6
    joints(arm)
    watch.run(300)
    arm.stop()
    watch.run()
    watch.check()
    assert not arm.busy and distance_from_path(watch, path) < 1e-4


def test_stop_after_a_redirection_stays_on_the_path(arm, watch):
    joints(arm)
    watch.run(150)
    home = arm.model.home
    path = path_of(arm, lambda other: other.move_to_configuration(home))
    arm.move_to_configuration(home)
    watch.rows = [watch.now()]
    watch.run(120)
    arm.stop()
    watch.run()
    watch.check()
    assert distance_from_path(watch, path) < 1e-3


def test_new_motion_replaces_a_paused_one(arm, watch):
    joints(arm)
    watch.run(200)
    arm.pause()
    watch.run()
    arm.move_to_configuration(arm.model.home)
    assert arm.paused  # the speed scale is still 0
    arm.resume()
    watch.run()
    assert np.array_equal(arm.q, arm.model.home)


@pytest.mark.parametrize("scale", [-0.1, 1.1, np.nan, "fast", "0.5", True])
def test_invalid_speed_scale_is_refused(arm, scale):
    with pytest.raises(MotionError, match="speed scale must be at least 0 and at most 1"):
        arm.speed_scale = scale
    assert arm.speed_scale == 1.0


@pytest.mark.parametrize("steps", [20, 400])  # while coming to rest, and at rest
def test_paused_arm_is_restored_bit_for_bit(arm, robot, watch, steps):
    joints(arm)
    watch.run(250)
    arm.pause()
    for _ in range(steps):
        arm.advance(DT)
    other = Arm(robot, ik=arm.ik)
    other.set_state(json.loads(json.dumps(arm.get_state())))
    for step in range(2500):
        if step == 300:
            arm.resume()
            other.resume()
        arm.advance(DT)
        other.advance(DT)
        assert np.array_equal(arm.q, other.q) and np.array_equal(arm.a, other.a)
    assert np.array_equal(arm.q, GOAL) and np.array_equal(other.q, GOAL)


def test_last_of_several_changes_within_milliseconds_is_reached(arm, watch):
    joints(arm)
    full = arm.remaining
    for scale in (0.1, 0.01, 1.0):
        arm.speed_scale = scale
        watch.run(5)
    watch.run(int(1.5 * full / DT))
    watch.check()
    assert np.array_equal(arm.q, GOAL) and not arm.busy


def test_change_that_the_limits_do_not_allow_yet_is_made_later(arm, watch, rng):
    lower, upper = arm.model.limits.lower + 0.1, arm.model.limits.upper - 0.1
    waited = 0
    for _ in range(12):
        arm.reset(arm.model.home)
        arm.speed_scale = 1.0
        watch.rows = [watch.now()]
        arm.move_to_configuration(rng.uniform(lower, upper))
        watch.run(int(rng.integers(50, 300)))
        arm.move_to_configuration(rng.uniform(lower, upper))
        watch.run(10)
        before = arm.remaining
        arm.speed_scale = 0.1
        waited += arm.remaining == before
        watch.run(400)
        assert arm.remaining > 3.0 * (before - 0.4)
        assert (np.abs(arm.v) <= 0.1001 * arm.model.limits.velocity).all()
        watch.check()
    assert waited > 0


@pytest.mark.parametrize("steps", range(1, 9))
def test_arm_paused_right_after_the_start_comes_to_rest(arm, watch, steps):
    arm.pause()
    joints(arm)
    arm.resume()
    watch.run(steps)
    arm.pause()
    watch.run()
    watch.check()
    assert arm.paused and not arm.v.any()
    arm.resume()
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


def test_arm_resumed_and_paused_in_one_step_can_be_resumed_again(arm, watch):
    arm.pause()
    joints(arm)
    arm.resume()
    arm.pause()
    watch.run(3)
    assert arm.paused
    arm.resume()
    watch.run()
    assert np.array_equal(arm.q, GOAL)


@pytest.mark.parametrize("scale", [0.5, 0.1])
def test_following_at_a_lower_speed_scale_is_slower(arm, watch, scale):
    T = arm.model.pose(arm.q)
    there = spatial.pointing_down(T.translation + [0.0, 0.3, -0.1])
    arm.speed_scale = scale
    for _ in range(60):
        arm.follow(there)
        watch.run(10)
    watch.check()
    fastest = np.max([np.abs(v) / arm.model.limits.velocity for _, v, _ in watch.rows])
    assert 0.3 * scale < fastest <= scale + 1e-9


def test_redirection_takes_the_same_path_at_any_speed_scale(arm, watch):
    paths = []
    for scale in (1.0, 0.4):
        arm.reset(arm.model.home)
        arm.speed_scale = scale
        joints(arm)
        watch.run(round(200 / scale))
        watch.rows = [watch.now()]
        arm.move_to_configuration(arm.model.home)
        watch.run()
        watch.check()
        paths.append(np.array([row[0] for row in watch.rows]))
    assert distance_from_path(watch, paths[0]) < 1e-4
    assert len(paths[1]) == pytest.approx(len(paths[0]) / 0.4, abs=3)


@pytest.mark.parametrize("slow", [1e-4, 1e-9, 5e-324])
@pytest.mark.parametrize("moving", [False, True])
def test_motion_that_takes_too_long_is_refused(arm, slow, moving):
    if moving:
        joints(arm)
        Watch(arm).run(100)
    before = arm.get_state()
    with pytest.raises(MotionError, match="would take .* at most 600 s are allowed"):
        arm.move_linear(spatial.pointing_down([0.45, 0.25, 0.3], 0.0), speed=slow)
    assert arm.get_state() == before
    if moving:
        with pytest.raises(MotionError, match="would take .* at most 600 s are allowed"):
            arm.speed_scale = slow
        assert arm.get_state() == before


def test_lagging_speed_scale_is_restored_bit_for_bit(arm, robot, watch, rng):
    lower, upper = arm.model.limits.lower + 0.1, arm.model.limits.upper - 0.1
    while not arm.get_state()["lagging"]:
        arm.reset(arm.model.home)
        arm.speed_scale = 1.0
        arm.move_to_configuration(rng.uniform(lower, upper))
        watch.run(150)
        arm.move_to_configuration(rng.uniform(lower, upper))
        watch.run(10)
        arm.speed_scale = 0.1
    other = Arm(robot, ik=arm.ik)
    other.set_state(json.loads(json.dumps(arm.get_state())))
    for _ in range(500):
        arm.advance(DT)
        other.advance(DT)
        assert np.array_equal(arm.q, other.q) and np.array_equal(arm.a, other.a)
    assert not arm.get_state()["lagging"]
