"""After a collision the arm yields, and drives away from where it is."""

import json

import numpy as np
import pytest

from bt_manip.exceptions import MotionError
from bt_manip.plugins import load_plugins
from tests.measuring.collisions import STRETCHED, collide, drive, one_arm

LARGEST_FORCE = 30.0  # [N]


@pytest.fixture(scope="module")
def collided(parts):
    """A station under computed torque that hit a wall 1.5 s ago, the collision, and the state."""
    station = one_arm("computed_torque", parts)
    collision = collide(station, 1.5)
    return station, collision, station.get_state()


def check_drive_home(station, collision):
    arm = station.arm
    assert collision.speed > 2.1 and collision.lasting < LARGEST_FORCE
    assert "touches 'wall'" in arm.fault
    assert arm.undisturbed and np.abs(arm.q - arm.robot.q).max() < 1e-3
    assert drive(station, collision.start) < LARGEST_FORCE
    assert not arm.fault and np.abs(arm.robot.q - collision.start).max() < 5e-3


def test_arm_that_hit_a_wall_does_not_press_and_drives_home(parts, collided):
    station, collision, state = collided
    station.set_state(state)
    check_drive_home(station, collision)
    station = one_arm("gravity_compensated_pd", parts)
    check_drive_home(station, collide(station, 1.5))


def test_arm_backs_off_along_the_path_just_travelled(collided):
    station, _, state = collided
    station.set_state(state)
    arm = station.arm
    travelled, tool = arm.follower.travelled, arm.robot.tool_pose.translation

    def deviation() -> float:
        return float(np.abs(travelled - arm.robot.q).max(axis=1).min())

    deflected = deviation()
    arm.back_off(0.1, speed=0.3)
    while arm.moving:
        station.cell.step()
        assert deviation() < deflected + 0.01
    station.cell.step(200)
    assert deviation() < 0.02
    moved = np.linalg.norm(arm.robot.tool_pose.translation - tool)
    assert not arm.fault and moved == pytest.approx(0.1, abs=0.005)


@pytest.mark.soak
@pytest.mark.parametrize("configuration", [None, STRETCHED], ids=["home", "stretched"])
@pytest.mark.parametrize("controller", load_plugins().parts.controllers.names())
def test_no_controller_presses_on_a_wall_for_ten_seconds(controller, configuration):
    station = one_arm(controller)
    check_drive_home(station, collide(station, 10.0, configuration))


def test_arm_that_hit_a_wall_with_a_cube_does_not_press_and_drives_home(situations):
    station = situations.reset("holding a cube over the table")
    collision = collide(station, 1.5)
    assert station.gripper.held and collision.forces.max() > 100.0
    check_drive_home(station, collision)


@pytest.mark.parametrize("steps", [20, 300])  # in the stop, and after it
def test_compliant_arm_is_restored_bit_for_bit_and_moves_again_when_it_rests(parts, steps):
    station = one_arm("computed_torque", parts)
    start = collide(station, 0.01).start
    station.cell.step(steps)
    if steps == 20:
        with pytest.raises(MotionError, match="has not come to rest") as error:
            station.arm.move_to_configuration(start)
        assert error.value.reason == "stopping"
    state = json.loads(json.dumps(station.get_state()))

    def go_on() -> bytes:
        station.cell.step(400)
        station.arm.move_to_configuration(start)
        station.cell.step(200)
        return station.cell.state_bytes()

    went_on = go_on()
    station.set_state(state)
    assert go_on() == went_on


@pytest.mark.parametrize("dt", [1e-3, 4e-3])
def test_an_arm_that_does_not_come_to_rest_after_a_compliant_stop_is_ready_after_a_second(
    arm, robot, monkeypatch, dt
):
    monkeypatch.setattr(robot, "read_v", lambda: np.full(7, 0.1))
    arm.stop(compliant=True)
    for _ in range(round(1.0 / dt)):
        with pytest.raises(MotionError, match="has not come to rest"):
            arm.check_ready()
        arm.advance(dt)
    arm.check_ready()
    assert arm.compliant


def test_path_back_is_remembered_across_motions_and_restored(arm, robot):
    home = arm.q_ref
    with pytest.raises(MotionError, match="no travelled path"):
        arm.back_off(0.1)
    for goal in (home + 0.2, home + [0.4, 0.2, 0.2, 0.2, 0.2, 0.2, 0.2]):
        arm.move_to_configuration(goal)
        while arm.moving:
            arm.advance(1e-3)
    state = json.loads(json.dumps(arm.get_state()))
    robot.set_configuration(goal)
    for _ in range(2):
        arm.back_off(10.0)
        while arm.moving:
            arm.advance(1e-3)
        first_end = arm.q_ref
        arm.set_state(state)
    assert np.array_equal(first_end, arm.follower.travelled[0]) and np.allclose(first_end, home)
