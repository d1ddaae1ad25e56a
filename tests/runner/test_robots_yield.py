"""Two robots in one cell get out of each other's way, and never touch."""

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.behaviours import Grasp, Hover, MoveToPose, Reach, pose_to_text
from bt_manip.bt import NodeStatus, Sequence
from bt_manip.collision import INTER_ROBOT_CLEARANCE
from bt_manip.exceptions import MotionError

from .conftest import set_up

MIDDLE = spatial.pointing_down((0.0, 0.0, 1.2))
BESIDE = spatial.pointing_down((0.0, 0.3, 1.2))


def solid(station, robot) -> list[int]:
    model = station.cell.model
    root = model.body_rootid[model.site_bodyid[robot.robot.tool_site_id]]
    mine = model.body_rootid[model.geom_bodyid] == root
    return np.flatnonzero(mine & (model.geom_contype != 0)).tolist()


def gap(station) -> float:
    """Measure the distance of the two robots by MuJoCo's own query, geom by geom [m]."""
    model, data, most = station.cell.model, station.cell.data, 0.2
    geoms = [solid(station, robot) for robot in station.robots.values()]
    nearest = most
    for a in geoms[0]:
        for b in geoms[1]:
            centres = np.linalg.norm(data.geom_xpos[a] - data.geom_xpos[b])
            if centres - model.geom_rbound[a] - model.geom_rbound[b] < nearest:
                nearest = min(nearest, mujoco.mj_geomDistance(model, data, a, b, most, None))
    return nearest


def smallest_gap(station, timeout: float = 6.0) -> float:
    """Let all motions come to their end, and give how near the robots came to each other [m]."""
    arms = [robot.arm for robot in station.robots.values()]
    nearest, end = gap(station), station.cell.time + timeout
    while any(arm.moving for arm in arms):
        assert station.cell.time < end
        station.cell.step(5)
        nearest = min(nearest, gap(station))
    return nearest


def test_a_target_where_another_robot_stands_is_refused_by_its_name(station, left, right):
    left.arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not left.arm.moving)
    with pytest.raises(MotionError, match="'left' blocks") as refused:
        right.arm.move_to_pose(MIDDLE)
    assert refused.value.reason == "robot" and not right.arm.moving


def test_another_robot_is_what_its_arm_moves_and_not_its_base(left):
    bodies = {left.arm.world.other_robot(f"right/{body}") for body in ("link1", "hand")}
    assert bodies == {"right"}
    assert left.arm.world.other_robot("right/link0") == ""  # nobody waits for it to go away
    assert left.arm.world.other_robot("left/hand") == left.arm.world.other_robot("table") == ""


def test_a_target_where_another_robot_will_come_to_rest_is_refused(left, right):
    left.arm.move_to_pose(MIDDLE)
    with pytest.raises(MotionError, match="'left' blocks"):
        right.arm.move_to_pose(MIDDLE)


def test_a_place_that_another_robot_is_leaving_is_taken_when_it_has_left(station, left, right):
    left.arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not left.arm.moving)
    left.arm.move_to_configuration(left.robot.description.home, speed=0.3)
    right.arm.move_to_pose(MIDDLE)
    assert right.arm.remaining > 0.8  # alone it takes 0.6 s
    assert smallest_gap(station) > 0.8 * INTER_ROBOT_CLEARANCE
    assert np.linalg.norm(right.robot.tool_pose.translation - MIDDLE.translation) < 2e-3


def at_random(station, rng, moves: int) -> tuple[float, int]:
    """Send both arms about the middle at random; give their smallest gap [m] and the moves made."""
    nearest, made = gap(station), 0
    for _ in range(moves):
        robot = station.robots[("left", "right")[int(rng.integers(2))]]
        place = rng.uniform((-0.2, -0.25, 1.1), (0.2, 0.25, 1.35))
        try:
            robot.arm.move_to_pose(spatial.pointing_down(place, rng.uniform(-1.5, 1.5)))
            made += 1
        except MotionError as error:
            assert error.reason in ("robot", "unreachable", "collision")
        for _ in range(int(rng.integers(2, 40))):  # so that many begin while others are under way
            station.cell.step(10)
            nearest = min(nearest, gap(station))
    return nearest, made


def test_arms_that_move_at_random_come_near_but_never_touch(station):
    nearest, made = at_random(station, np.random.default_rng(0), 25)
    assert made >= 12 and 0.6 * INTER_ROBOT_CLEARANCE < nearest < 5.0 * INTER_ROBOT_CLEARANCE
    assert not any(robot.arm.fault for robot in station.robots.values())


@pytest.mark.soak
def test_arms_that_move_at_random_for_long_never_touch(station):
    nearest, made = at_random(station, np.random.default_rng(1), 600)
    assert made >= 250 and nearest > 0.5 * INTER_ROBOT_CLEARANCE
    assert not any(robot.arm.fault for robot in station.robots.values())


def test_a_behaviour_waits_until_the_other_robot_has_gone(station, left, right):
    left.arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not left.arm.moving)
    waiting = set_up(station, MoveToPose(robot="right", pose=pose_to_text(MIDDLE)))
    for _ in range(50):
        assert waiting.tick() is NodeStatus.RUNNING
    assert "waits: 'left' blocks" in waiting.behaviour.feedback_message
    assert not right.arm.moving
    left.arm.move_to_configuration(left.robot.description.home)
    assert waiting.until_done(6.0) is NodeStatus.SUCCESS


def test_a_behaviour_fails_when_the_other_robot_stays_for_too_long(station, left):
    left.arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not left.arm.moving)
    for wait in (0.0, 0.5):
        start = station.cell.time
        impatient = MoveToPose(robot="right", pose=pose_to_text(MIDDLE), wait=wait)
        assert set_up(station, impatient).fails_with("'left' blocks")
        assert station.cell.time - start == pytest.approx(wait, abs=0.02)


def test_an_arm_stops_when_another_one_is_stopped_in_its_way(station, left, right):
    left.arm.move_to_pose(MIDDLE)
    station.step_until(lambda: not left.arm.moving)
    left.arm.move_to_configuration(left.robot.description.home, speed=0.3)
    right.arm.move_to_pose(MIDDLE)
    station.cell.step(100)
    left.arm.stop()
    assert "'left' blocks" in right.arm.fault
    assert smallest_gap(station) > 0.5 * INTER_ROBOT_CLEARANCE
    assert np.linalg.norm(right.robot.tool_pose.translation - MIDDLE.translation) > 0.05


def test_an_arm_goes_on_when_another_one_is_stopped_elsewhere(station, left, right):
    left.arm.move_to_pose(spatial.pointing_down((-0.2, 0.2, 1.2)))
    right.arm.move_to_pose(MIDDLE * spatial.pose((0.2, 0.0, 0.0)))
    station.cell.step(100)
    left.arm.stop()
    assert not right.arm.fault and smallest_gap(station) > INTER_ROBOT_CLEARANCE


def test_an_arm_that_was_paused_does_not_go_on_into_one_that_has_come_since(station, left, right):
    left.arm.move_to_pose(spatial.pointing_down((-0.25, 0.0, 1.2)))
    station.step_until(lambda: not left.arm.moving)
    left.arm.move_linear(spatial.pointing_down((0.1, 0.0, 1.2)), speed=0.3)
    station.cell.step(100)
    left.arm.pause()
    station.step_until(lambda: left.arm.paused)
    right.arm.move_to_pose(spatial.pointing_down((0.15, 0.0, 1.2)))  # around where it rests
    station.step_until(lambda: not right.arm.moving)
    left.arm.resume()
    assert "'right' blocks" in left.arm.fault
    assert smallest_gap(station) > 0.5 * INTER_ROBOT_CLEARANCE


def test_an_arm_at_a_slower_pace_lets_the_other_one_pass_as_well(station, left, right):
    left.arm.speed_scale = right.arm.speed_scale = 0.4
    nearest, made = at_random(station, np.random.default_rng(5), 15)
    assert made >= 5 and nearest > 0.5 * INTER_ROBOT_CLEARANCE


def test_what_another_robot_holds_is_in_the_way_as_well(station, left, right):
    pick = [leaf(object="cube", robot="left") for leaf in (Hover, Reach, Grasp)]
    assert set_up(station, Sequence("pick", pick)).until_done(9.0) is NodeStatus.SUCCESS
    left.arm.move_linear(MIDDLE)  # where it holds the cube up: 30 mm of it below the fingers
    below = spatial.pointing_down((0.0, 0.0, 1.1))
    with pytest.raises(MotionError, match="'left' blocks"):
        right.arm.move_to_pose(below)


def test_fingers_of_two_robots_that_touch_are_no_grip(station, left, right):
    cell = station.cell
    tool = left.robot.tool_pose.translation
    for robot, y in ((left, 0.004), (right, -0.004)):
        away = spatial.pointing_down((0.0, y, 1.3), 0.0)
        found = robot.arm.ik.nearest(away, robot.robot.q)
        assert found.solved, tool
        robot.robot.set_configuration(found.q)
    mujoco.mj_forward(cell.model, cell.data)
    pairs = cell.contact_monitor.summary().unexpected
    assert any({a.split("/")[0], b.split("/")[0]} == {"left", "right"} for a, b in pairs)
    fingers = [pair for pair in pairs if all("finger" in body for body in pair)]
    assert fingers
