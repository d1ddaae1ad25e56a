"""The pace of a motion changes while it goes on, and the arm stays on its path."""

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


def way_of(arm, ask) -> np.ndarray:
    """Drive a motion at full pace on a copy of the arm; give its configurations."""
    other = Arm(arm.robot, ik=arm.ik)
    other.set_state(arm.get_state())
    ask(other)
    watched = Watch(other)
    watched.run()
    return np.array([row[0] for row in watched.rows])


def off_the_way(watch, way: np.ndarray) -> float:
    """Give how far configurations are from a finely sampled way, at the most [rad]."""
    worst = 0.0
    for q, *_ in watch.rows:
        i = int(np.abs(way - q).max(axis=1).argmin())
        near = way[max(0, i - 1) : i + 2]
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
def test_paused_it_rests_on_its_path_and_resumed_it_arrives(arm, watch, ask):
    way = way_of(arm, ask)
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
    assert off_the_way(watch, way) < 1e-4


def test_at_half_the_pace_the_rest_takes_twice_the_time(arm, watch):
    joints(arm)
    watch.run(200)
    remaining = arm.remaining
    arm.speed_scale = 0.5
    watch.check()
    assert arm.remaining == pytest.approx(2 * remaining, rel=0.15)
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


def test_the_pace_holds_for_motions_to_come_too(arm, watch):
    joints(arm)
    full = arm.remaining
    arm.reset()
    arm.speed_scale = 0.25
    joints(arm)
    assert arm.remaining == pytest.approx(4 * full)
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


def test_at_no_pace_a_motion_waits_until_there_is_one(arm, watch):
    arm.speed_scale = 0.0
    joints(arm)
    assert arm.paused and not arm.moving
    arm.speed_scale = 1.0
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


def test_changed_at_random_moments_it_keeps_to_limits_and_path(arm, watch, rng):
    way = way_of(arm, joints)
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
    assert off_the_way(watch, way) < 1e-4
    assert watch.worst_effort() <= 0.9501


def test_a_stop_in_a_pause_gives_the_motion_up(arm, watch):
    joints(arm)
    watch.run(200)
    arm.pause()
    watch.run()
    arm.stop()
    arm.resume()
    assert not arm.busy


def test_a_stop_at_a_lower_pace_stays_on_the_path(arm, watch):
    way = way_of(arm, joints)
    arm.speed_scale = 0.6
    joints(arm)
    watch.run(300)
    arm.stop()
    watch.run()
    watch.check()
    assert not arm.busy and off_the_way(watch, way) < 1e-4


def test_a_motion_that_was_redirected_stops_on_its_way(arm, watch):
    joints(arm)
    watch.run(150)
    home = arm.model.home
    way = way_of(arm, lambda other: other.move_to_configuration(home))
    arm.move_to_configuration(home)
    watch.rows = [watch.now()]
    watch.run(120)
    arm.stop()
    watch.run()
    watch.check()
    assert off_the_way(watch, way) < 1e-3


def test_a_new_motion_replaces_a_paused_one(arm, watch):
    joints(arm)
    watch.run(200)
    arm.pause()
    watch.run()
    arm.move_to_configuration(arm.model.home)
    assert arm.paused  # the pace is still nought
    arm.resume()
    watch.run()
    assert np.array_equal(arm.q, arm.model.home)


@pytest.mark.parametrize("pace", [-0.1, 1.1, np.nan, "fast", "0.5", True])
def test_a_pace_that_is_none_is_refused(arm, pace):
    with pytest.raises(MotionError, match="speed scale must be at least 0 and at most 1"):
        arm.speed_scale = pace
    assert arm.speed_scale == 1.0


@pytest.mark.parametrize("steps", [20, 400])  # on the way to rest, and at rest
def test_paused_it_is_restored_bit_for_bit(arm, robot, watch, steps):
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


def test_turned_down_and_up_again_within_milliseconds_it_reaches_the_last_pace(arm, watch):
    joints(arm)
    full = arm.remaining
    for pace in (0.1, 0.01, 1.0):
        arm.speed_scale = pace
        watch.run(5)
    watch.run(int(1.5 * full / DT))
    watch.check()
    assert np.array_equal(arm.q, GOAL) and not arm.busy


def test_a_change_that_the_limits_do_not_allow_yet_is_made_as_soon_as_they_do(arm, watch, rng):
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
def test_paused_as_soon_as_it_sets_out_it_rests(arm, watch, steps):
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


def test_paused_and_resumed_in_the_same_step_it_goes_on(arm, watch):
    arm.pause()
    joints(arm)
    arm.resume()
    arm.pause()
    watch.run(3)
    assert arm.paused
    arm.resume()
    watch.run()
    assert np.array_equal(arm.q, GOAL)


@pytest.mark.parametrize("pace", [0.5, 0.1])
def test_following_at_a_lower_pace_is_slower(arm, watch, pace):
    T = arm.model.pose(arm.q)
    there = spatial.pointing_down(T.translation + [0.0, 0.3, -0.1])
    arm.speed_scale = pace
    for _ in range(60):
        arm.follow(there)
        watch.run(10)
    watch.check()
    fastest = np.max([np.abs(v) / arm.model.limits.velocity for _, v, _ in watch.rows])
    assert 0.3 * pace < fastest <= pace + 1e-9


def test_a_motion_is_redirected_on_the_same_way_at_any_pace(arm, watch):
    ways = []
    for pace in (1.0, 0.4):
        arm.reset(arm.model.home)
        arm.speed_scale = pace
        joints(arm)
        watch.run(round(200 / pace))
        watch.rows = [watch.now()]
        arm.move_to_configuration(arm.model.home)
        watch.run()
        watch.check()
        ways.append(np.array([row[0] for row in watch.rows]))
    assert off_the_way(watch, ways[0]) < 1e-4
    assert len(ways[1]) == pytest.approx(len(ways[0]) / 0.4, abs=3)


@pytest.mark.parametrize("slow", [1e-4, 1e-9, 5e-324])
@pytest.mark.parametrize("moving", [False, True])
def test_what_would_take_for_ever_is_refused(arm, slow, moving):
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


def test_a_pace_that_is_waited_for_is_restored_bit_for_bit(arm, robot, watch, rng):
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
