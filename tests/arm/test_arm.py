"""Motions of the arm, checked at every control step as a controller sees them."""

import json

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.planning import LineTo
from bt_manip.robots import Payload

from .watch import DT, Watch

BELOW = spatial.pose((0.0, 0.0, 0.1))
"""Pose 10 cm ahead of a tool, in its frame."""


def down(x, y, z, yaw=0.0):
    return spatial.pointing_down([x, y, z], yaw)


def test_arm_starts_at_rest_at_the_measured_configuration(robot, arm):
    assert np.array_equal(arm.q, robot.q) and not arm.q.flags.writeable
    assert not arm.v.any() and not arm.a.any()
    assert not arm.moving and arm.remaining == 0.0
    arm.stop()
    arm.advance(DT)
    assert np.array_equal(arm.q, robot.q)


def test_motion_between_configurations_is_a_straight_joint_space_segment(arm, watch, rng):
    limits = arm.model.limits
    for _ in range(4):
        start, target = arm.q.copy(), rng.uniform(limits.lower, limits.upper)
        watch.rows = [watch.now()]
        arm.move_to_configuration(target)
        watch.run()
        watch.check()
        assert np.array_equal(arm.q, target)
        direction = (target - start) / np.linalg.norm(target - start)
        from_start = np.array([row[0] for row in watch.rows]) - start
        assert np.abs(from_start - np.outer(from_start @ direction, direction)).max() < 1e-12


@pytest.mark.parametrize(
    "move",
    [
        lambda arm, speed: arm.move_to_configuration(arm.model.home + 0.3, speed=speed),
        lambda arm, speed: arm.move_to_pose(down(0.4, 0.1, 0.4), speed=speed),
        lambda arm, speed: arm.move_linear(arm.model.pose(arm.q) * BELOW, speed=speed),
        lambda arm, speed: arm.move_path([LineTo(arm.model.pose(arm.q) * BELOW)], speed=speed),
    ],
)
def test_at_half_speed_a_move_from_rest_takes_twice_the_time(arm, move):
    durations = []
    for speed in (1.0, 0.5):
        arm.reset()
        move(arm, speed)
        durations.append(arm.remaining)
    assert durations[1] == pytest.approx(2.0 * durations[0], rel=2e-3)


def test_no_motion_is_planned_to_the_present_configuration(arm):
    for distance in (0.0, 1e-16, 1e-11):  # [rad]
        arm.move_to_configuration(arm.q + distance)
        assert not arm.moving
    arm.move_linear(arm.model.pose(arm.q))
    assert not arm.moving


def test_move_to_pose_brings_the_tool_to_the_nearest_of_equivalent_poses(arm, watch, monkeypatch):
    # Without a length no straight approach is planned.
    monkeypatch.setattr("bt_manip.planning.goal_selection.plan_straight_approach", pytest.fail)
    poses = [down(0.4, 0.0, 0.3, yaw) for yaw in (np.pi, 0.1, -0.5 * np.pi)]
    arm.move_to_pose(poses)
    watch.run()
    watch.check()
    assert pin.log6(arm.model.pose(arm.q).actInv(poses[1])).np == pytest.approx(0, abs=2e-6)


def test_an_unreachable_pose_is_refused_with_the_distance_of_the_nearest_one_that_was_found(arm):
    T_wt = down(0.1, 0.0, 0.9)  # in reach, but not pointing down
    with pytest.raises(MotionError, match="the pose is unreachable") as raised:
        arm.move_to_pose(T_wt)
    nearest = T_wt.actInv(arm.model.pose(arm.ik.nearest(T_wt, arm.q, margin=0.05).q))
    away, turn = np.linalg.norm(nearest.translation), np.linalg.norm(pin.log3(nearest.rotation))
    told = f"; nearest found is {1000.0 * away:.1f} mm and {turn:.3f} rad away"
    assert str(raised.value).endswith(told) and raised.value.reason == "unreachable"


def test_straight_approach_is_possible_from_a_pose_with_approach(arm, watch):
    for x, y, yaw in ((0.32, 0.1, 1.1), (0.3, -0.28, 2.9), (0.5, 0.3, -2.0)):
        arm.move_to_pose([down(x, y, 0.43, yaw + k * np.pi / 2) for k in range(4)], approach=0.38)
        watch.run()
        T = arm.model.pose(arm.q)
        arm.move_linear(T * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.38])))
        watch.run()
    watch.check()


def test_motion_with_a_payload_beyond_the_effort_limits_is_refused(arm):
    arm.payload = Payload(40.0)
    with pytest.raises(MotionError, match="joint") as raised:
        arm.move_to_configuration(arm.model.home + 0.3)
    assert raised.value.reason == "effort"
    assert not arm.moving


def test_motion_does_not_depend_on_the_control_step(robot):
    fine, coarse = Arm(robot), Arm(robot)
    for arm in (fine, coarse):
        arm.move_to_configuration(arm.model.home + 0.3)
    for _ in range(50):
        for _ in range(4):
            fine.advance(0.5e-3)
        coarse.advance(2e-3)
        assert np.abs(fine.q - coarse.q).max() < 1e-12
    coarse.advance(1e-3)  # and it may change during a motion
    for _ in range(2):
        fine.advance(0.5e-3)
    assert np.abs(fine.q - coarse.q).max() < 1e-12
    left, steps = coarse.remaining, 0
    while coarse.moving:
        coarse.advance(1e-3)
        steps += 1
    assert steps == pytest.approx(1e3 * left, abs=2.01)


@pytest.mark.parametrize(
    "kind", ["line after a stop", "turned", "stopped", "pausing", "paused", "blend", "rest"]
)
def test_restored_arm_continues_bit_for_bit(robot, kind):
    arm = Arm(robot)
    watch = Watch(arm)
    arm.payload = Payload(0.3, [0.0, 0.0, 0.02], 1e-4 * np.eye(3))
    if kind == "stopped":
        arm.move_linear(down(0.4, 0.2, 0.3))
    elif kind != "rest":
        arm.move_to_configuration(arm.model.home + 0.5)
    watch.run(137)
    if kind == "turned":
        arm.move_to_configuration(arm.model.home)
    elif kind == "line after a stop":
        arm.move_linear(down(0.4, 0.2, 0.3))
    elif kind == "stopped":
        arm.stop()
    elif kind in ("pausing", "paused"):
        arm.pause()
    elif kind == "blend":
        while not arm.ends_within(0.2):
            arm.advance(DT)
        arm.blend_radius = 0.2
        arm.move_linear(down(0.4, 0.2, 0.3))
        assert arm.trajectory.get_state()["kind"] == "blended"
    watch.run(300 if kind == "paused" else 31)
    assert arm.paused == (kind == "paused")
    other = Arm(robot)
    other.set_state(json.loads(json.dumps(arm.get_state())))
    assert other.get_state() == arm.get_state() and other.payload.mass == 0.3
    changes = {300: Arm.resume, 400: Arm.stop} if "paus" in kind else {40: Arm.stop}
    for step in range(600 if "paus" in kind else 300):
        for each in (arm, other):
            each.advance(DT)
            changes.get(step, Arm.get_state)(each)
        for mine, its in zip((arm.q, arm.v, arm.a), (other.q, other.v, other.a), strict=True):
            assert np.array_equal(mine, its), step
    assert not arm.moving and not other.moving


HERE = down(0.4, 0.0, 0.3)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda arm: arm.move_to_configuration(np.full(7, np.nan)), "7 finite numbers"),
        (lambda arm: arm.move_to_configuration([0.0] * 6), "7 finite numbers"),
        (lambda arm: arm.move_to_configuration("home"), "numbers"),
        (lambda arm: arm.move_to_configuration([0.0] * 7), "joint 4 cannot go to 0.0000 rad"),
        (lambda arm: arm.move_to_configuration(arm.model.home, speed=0.0), "above 0 and at most 1"),
        (lambda arm: arm.move_to_configuration(arm.model.home, speed=1.5), "above 0 and at most 1"),
        (lambda arm: arm.move_to_pose(HERE, speed=np.nan), "above 0 and at most 1"),
        (lambda arm: arm.move_to_pose(np.eye(4)), "pose must be a pin.SE3"),
        (lambda arm: arm.move_to_pose([]), "no target pose"),
        (lambda arm: arm.move_to_pose(down(np.inf, 0, 0.3)), "pose must be finite"),
        (lambda arm: arm.move_linear(down(np.nan, 0, 0.3)), "pose must be finite"),
        (lambda arm: arm.move_linear([0.4, 0.0, 0.3]), "pose must be a pin.SE3, got list"),
        (lambda arm: arm.move_linear(down(1.4, 0, 0.4)), r"line can be followed only for \d+ %"),
        (lambda arm: arm.move_to_pose(down(1.2, 0, 0.3)), "unreachable: .* out of reach"),
        (lambda arm: arm.move_to_pose(HERE, margin=-0.1), "margin .* least 0 .rad., got -0.1"),
        (lambda arm: arm.move_to_pose(HERE, approach=np.nan), "approach .* least 0 .m., got nan"),
        (lambda arm: arm.move_to_pose(HERE, planner="rrt"), "a planner is .*, got 'rrt'"),
        (lambda arm: arm.move_to_configuration(arm.model.home, rng=3), "Generator, got 3"),
        (lambda arm: arm.move_path(LineTo(HERE)), "a path is a list of .*, got LineTo"),
        (lambda arm: arm.move_path([HERE]), "a step of a path is a .*, got SE3"),
        (lambda arm: arm.move_path([LineTo(HERE)], blend="wide"), "blend must be at least 0 .m."),
        (lambda arm: arm.servo(arm.q_ref, np.full(7, np.nan), 0.05), "velocity"),
    ],
)
def test_invalid_input_raises_and_changes_nothing(arm, watch, ask, message):
    arm.move_to_configuration(arm.model.home + 0.3)
    watch.run(100)
    before = arm.get_state()
    with pytest.raises(MotionError, match=message) as raised:
        ask(arm)
    assert "\n" not in str(raised.value)
    assert arm.get_state() == before


@pytest.mark.parametrize("side", ["lower", "upper"])
def test_joint_at_its_position_limit_is_neither_refused_as_start_nor_as_goal(arm, side):
    limit, home = getattr(arm.model.limits, side)[2], arm.model.home
    outwards = np.sign(limit)
    at_limit = home.copy()
    for beyond in (-1e-6, 0.0, 1e-6):
        at_limit[2] = limit + outwards * beyond
        arm.reset(home)
        arm.move_to_configuration(at_limit)
        assert np.abs(arm.target - at_limit).max() <= 1.001e-6
        arm.reset(at_limit)
        arm.move_to_configuration(home)
        assert np.array_equal(arm.target, home)
    at_limit[2] = limit + outwards * 2e-6
    with pytest.raises(MotionError, match="joint 3 cannot go to"):
        arm.move_to_configuration(at_limit)


def test_servo_passes_targets_on_a_smooth_motion_in_time(arm, watch):
    """A policy that repeats a planned motion step by step repeats it."""
    start, duration = arm.q.copy(), 0.05
    arm.move_to_configuration(start + 0.4, speed=0.8)
    planned = arm.trajectory
    arm.reset(start)
    watch.rows = [watch.now()]
    for i in range(1, int(planned.duration / duration) + 1):
        q, v, _ = (rows[0] for rows in planned.sample(np.array([i * duration])))
        arm.servo(q, v, duration)
        watch.run(50)
        assert np.abs(arm.q - q).max() < 1e-3
    watch.run()
    watch.check()


def test_servo_asks_for_velocities_from_which_the_arm_can_brake(arm):
    limits, home, wrist, T = arm.model.limits, arm.q_ref, np.eye(7)[6], 0.05
    home[6] = limits.upper[6] - 0.05
    a = 0.7 * limits.acceleration[6]
    for by, v, expected in (
        (-0.03, -0.1, 0.1 + (0.03 - 0.5 * 0.1 * T) / T),  # passed in time
        (-0.04, 0.2, -0.2 + (0.04 + 0.5 * 0.2 * T) / T),  # and turned back after it
        (-0.15, 0.0, np.sqrt(2.0 * a * 0.15)),  # farther than it can go, and stop, in the time
        (-2.0, 0.0, 0.98 * limits.velocity[6]),
        (9.0, 0.3, np.sqrt(a * 0.05)),  # near its limit
    ):
        arm.reset(home)
        arm.servo(home + by * wrist, v * wrist, T)
        _, rates, _ = arm.trajectory.sample(np.linspace(0.0, arm.trajectory.duration, 3000))
        assert np.abs(rates).max(axis=0) == pytest.approx(expected * wrist, rel=1e-3, abs=1e-9)
    arm.reset(home - 0.2 * wrist)
    for by in (-0.15, 9.0):  # by then it moves, and needs some of the room in the time
        room = limits.upper[6] - arm.q[6] - T * arm.v[6]
        arm.servo(home + by * wrist, 0.2 * wrist, T)
        _, rates, _ = arm.trajectory.sample(np.linspace(0.0, arm.trajectory.duration, 3000))
        for _ in range(50):
            arm.advance(DT)
    assert np.abs(rates[:, 6]).max() == pytest.approx(np.sqrt(a * room), rel=1e-3)
