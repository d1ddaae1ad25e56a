"""Time scaling, pause and stop: a motion changes its speed and stays on its path."""

import json

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from tests.measuring.stops import distance

from .watch import Watch

GOAL = np.array([0.9, 0.3, -0.4, -1.9, 0.5, 1.9, -0.3])


def joints(arm):
    arm.move_to_configuration(GOAL)


def test_the_travelled_path_ends_within_its_spacing_of_the_arm_at_every_step(arm):
    joints(arm)
    while arm.moving:
        arm.follower.advance(1e-3)
        travelled = arm.follower.travelled
        assert np.abs(travelled[-1] - arm.q).max() < 0.02
        assert np.abs(np.diff(travelled, axis=0)).max(initial=0.0) < 0.025  # and 2.6 mrad a step
        assert not arm.follower.lagging
    arm.move_to_configuration(GOAL - 1.2 * np.eye(7)[0])
    while arm.moving:
        arm.advance(1e-3)
    back = arm.follower.travelled[:, 0] - GOAL[0]  # the path of the last 1.3 rad
    assert len(back) <= 64 and back.max() > -0.02 and back.min() < -1.18


def test_a_motion_requested_at_speed_scale_zero_is_paused_replaced_and_discarded(arm, watch):
    arm.speed_scale = 0.0
    joints(arm)
    assert arm.paused and not arm.moving
    arm.speed_scale = 1.0
    watch.run(200)
    arm.pause()
    watch.run()
    arm.move_to_configuration(arm.model.home)
    assert arm.paused  # the speed scale is still 0
    arm.resume()
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, arm.model.home)
    joints(arm)
    watch.run(200)
    arm.pause()
    watch.run()
    arm.stop()
    arm.resume()
    assert not arm.busy


@pytest.mark.parametrize("scale", [-0.1, 1.1, np.nan, "0.5", True])
def test_invalid_speed_scale_is_refused(arm, scale):
    with pytest.raises(MotionError, match="speed scale must be at least 0 and at most 1"):
        arm.speed_scale = scale
    assert arm.speed_scale == 1.0


@pytest.mark.parametrize("steps", [0, 1, 8])
def test_arm_paused_at_or_right_after_the_start_comes_to_rest(arm, watch, steps):
    arm.pause()
    joints(arm)
    arm.resume()
    watch.run(steps)
    arm.pause()
    watch.run()
    watch.check()
    assert arm.paused and arm.busy and not arm.moving and not arm.v.any()
    arm.resume()
    watch.run()
    watch.check()
    assert np.array_equal(arm.q, GOAL)


@pytest.mark.parametrize(("scale", "speed"), [(0.5, 1.0), (1.0, 0.5)])
def test_following_at_a_lower_speed_is_slower(arm, watch, scale, speed):
    T = arm.model.pose(arm.q)
    there = spatial.pointing_down(T.translation + [0.0, 0.3, -0.1])
    arm.speed_scale = scale
    for _ in range(60):
        arm.follow(there, speed=speed)
        watch.run(10)
    watch.check()
    fastest = np.max([np.abs(v) / arm.model.limits.velocity for _, v, _ in watch.rows])
    assert 0.15 < fastest <= 0.5 + 1e-9


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
    assert max(distance(paths[0], q) for q, *_ in watch.rows) < 1e-4
    assert len(paths[1]) == pytest.approx(len(paths[0]) / 0.4, abs=3)


@pytest.mark.parametrize("slow", [1e-4, 5e-324])
def test_motion_that_takes_too_long_is_refused(arm, watch, slow):
    joints(arm)
    watch.run(100)
    before = arm.get_state()
    with pytest.raises(MotionError, match="would take .* at most 600 s are allowed"):
        arm.move_linear(spatial.pointing_down([0.45, 0.25, 0.3], 0.0), speed=slow)
    with pytest.raises(MotionError, match="would take .* at most 600 s are allowed"):
        arm.speed_scale = slow
    assert arm.get_state() == before


def test_change_that_the_limits_do_not_allow_yet_is_made_later_and_restored(arm, robot, watch, rng):
    lower, upper = arm.model.limits.lower + 0.1, arm.model.limits.upper - 0.1
    waited = 0
    for _ in range(5):
        arm.reset(arm.model.home)
        arm.speed_scale = 1.0
        watch.rows = [watch.now()]
        arm.move_to_configuration(rng.uniform(lower, upper))
        watch.run(int(rng.integers(50, 300)))
        arm.move_to_configuration(rng.uniform(lower, upper))
        watch.run(10)
        before = arm.remaining
        arm.speed_scale = 0.1
        if arm.get_state()["lagging"]:
            assert arm.remaining == before
            waited += 1
        other = Watch(Arm(robot, ik=arm.ik))
        other.arm.set_state(json.loads(json.dumps(arm.get_state())))
        watch.run(400)
        other.run(400)
        assert np.array_equal(watch.rows[-400:], other.rows[1:])
        assert not arm.get_state()["lagging"]
        assert arm.remaining > 3.0 * (before - 0.4)
        assert (np.abs(arm.v) <= 0.1001 * arm.model.limits.velocity).all()
        watch.check()
    assert waited > 0
