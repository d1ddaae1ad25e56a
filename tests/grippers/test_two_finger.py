"""Two fingers open, close and hold a cube by friction alone."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from dm_control import composer

from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import GripperError, Robot, RobotError, panda
from tests.support.arms import Wave, panda_cell
from tests.support.arms import step_until as step_until


def test_closing_ends_with_the_asked_force_on_each_finger_for_50_ms(grip):
    cell, robot, control, gripper = grip
    gripper.close(50.0)
    assert gripper.state == "closing" and gripper.moving
    forces = []
    while not gripper.steady:
        cell.step()
        forces.append(gripper.forces)
        assert cell.time < 0.4
    last = np.array(forces[-50:])
    assert ((last >= 47.5) & (last <= 60.0)).all()
    assert np.max(forces) < 60.0  # no impact
    assert gripper.held == ("cube",)
    assert not gripper.moving


def test_the_forces_are_the_contact_forces(grip):
    cell, robot, control, gripper = grip
    gripper.close(30.0)
    step_until(cell, lambda: gripper.steady)
    for force, finger in zip(gripper.forces, ("left_finger", "right_finger"), strict=True):
        assert force == pytest.approx(cell.contacts.between(f"panda/{finger}", "cube").normal)
        assert force == pytest.approx(30.0, rel=0.02)


@pytest.mark.parametrize("offset", [0.004, -0.01])
def test_a_cube_off_centre_is_gripped_and_not_shot_away(offset):
    cell, robot, control, gripper = panda_cell(offset)
    gripper.close()
    fastest = 0.0
    while not gripper.steady:
        cell.step()
        fastest = max(fastest, np.linalg.norm(cell.velocity("cube")[:3]))
        assert cell.time < 0.6
    assert fastest < 0.15
    assert gripper.held == ("cube",)


def test_a_held_cube_neither_sinks_in_nor_creeps(grip):
    cell, robot, control, gripper = grip
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    cell.remove("post")  # now friction alone holds it
    cell.step(50)
    before = cell.pose("cube").translation
    cell.step(500)
    crept = np.linalg.norm(cell.pose("cube").translation - before) / 0.5
    assert crept < 1e-4
    assert cell.contacts.pairs() == [("cube", "panda/left_finger"), ("cube", "panda/right_finger")]
    assert cell.data.contact.dist.min() > -5e-4  # [m]
    weight = cell.contacts.wrench("cube").force
    np.testing.assert_allclose(weight, (0, 0, 0.0565 * 9.81), atol=0.02)


def test_a_held_cube_stays_while_the_arm_moves_hard(grip):
    """Up to 10 rad/s2 in every joint: the cube slips less than 0.1 mm/s, the force stays."""
    cell, robot, control, gripper = grip
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    cell.remove("post")
    control.reference = Wave(robot.q, 0.1, 10.0)

    def held_at():
        body = cell.data.body("cube/")
        rotation = robot.tool_pose.rotation
        return rotation.T @ (body.xpos - robot.tool_pose.translation)

    cell.step()
    start, forces = held_at(), []
    for _ in range(628 * 2):  # two periods: back where it began
        cell.step()
        forces.append(gripper.forces)
        assert gripper.steady
    assert np.linalg.norm((held_at() - start)[[0, 2]]) / 1.256 < 1e-4
    assert 47.5 < np.min(forces) and np.max(forces) < 60


def test_opening_lets_the_cube_stand(grip):
    cell, robot, control, gripper = grip
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    before = cell.pose("cube").translation
    gripper.open()
    fastest = 0.0

    def watched():
        nonlocal fastest
        fastest = max(fastest, np.linalg.norm(cell.velocity("cube")[:3]))
        return gripper.is_open

    step_until(cell, watched)
    assert fastest < 0.02
    np.testing.assert_allclose(cell.pose("cube").translation, before, atol=5e-4)
    assert gripper.is_free and gripper.held == ()
    assert gripper.state == "still" and not gripper.moving


def test_fingers_that_meet_say_so():
    cell, robot, control, gripper = panda_cell(cube=False)
    gripper.close(50.0)
    step_until(cell, lambda: gripper.closed_on_nothing)
    cell.step(200)
    assert gripper.width < 1e-3
    assert not gripper.steady and not gripper.moving
    assert gripper.held == ()
    assert max(gripper.forces) < 6.0


def test_a_move_is_soft_and_arrives():
    cell, robot, control, gripper = panda_cell(cube=False)
    gripper.move(0.03)
    widths = [gripper.width]
    while gripper.moving:
        cell.step()
        widths.append(gripper.width)
        assert cell.time < 0.5
    speed = np.diff(widths) / cell.dt
    assert gripper.width == pytest.approx(0.03, abs=1e-4)
    assert np.abs(speed).max() < 2 * 0.1 * 1.02
    assert np.abs(np.diff(speed) / cell.dt).max() < 2 * 5.0 * 1.5


def test_a_stop_brakes_where_it_is_and_keeps_what_is_held(grip):
    cell, robot, control, gripper = grip
    gripper.close()
    cell.step(80)
    gripper.stop()
    step_until(cell, lambda: not gripper.moving, 0.1)
    assert 0.055 < gripper.width < 0.075
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    gripper.stop()
    cell.step(100)
    assert gripper.steady


def test_a_stopped_release_holds_again(grip):
    cell, robot, control, gripper = grip
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    gripper.open()
    cell.step(20)
    assert gripper.forces[0] < 40
    gripper.stop()
    step_until(cell, lambda: gripper.steady, 0.3)
    assert gripper.held == ("cube",)


def test_the_force_of_a_grip_can_be_changed(grip):
    cell, robot, control, gripper = grip
    gripper.close(20.0)
    step_until(cell, lambda: gripper.steady)
    gripper.close(70.0)
    assert not gripper.steady
    step_until(cell, lambda: gripper.steady, 0.3)
    np.testing.assert_allclose(gripper.forces, 70.0, rtol=0.05)


@pytest.mark.parametrize("when", [60, 190, 215, 330])
def test_its_state_comes_back_bit_for_bit(grip, when):
    """In the middle of the approach, of the ramp, of the grip and of the release."""
    cell, robot, control, gripper = grip
    gripper.close()
    for _ in range(when):
        cell.step()
        if gripper.steady and gripper.state == "gripping" and when > 300:
            gripper.open()
    kept = cell.snapshot(), control.get_state(), gripper.get_state()
    held = gripper.held
    cell.step(150)
    future, after = cell.state_bytes(), gripper.get_state()
    cell.restore(kept[0])
    control.set_state(kept[1])
    gripper.set_state(kept[2])
    assert gripper.held == held
    cell.step(150)
    assert cell.state_bytes() == future
    assert gripper.get_state() == after


def test_what_it_holds_is_still_known_after_something_is_added(grip):
    cell, robot, control, gripper = grip
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    cell.remove("post")
    assert gripper.steady
    assert gripper.held == ("cube",)


@pytest.mark.parametrize(
    ("command", "message"),
    [
        (lambda g: g.close(0.0), "holds with up to 140 N, not 0 N"),
        (lambda g: g.close(200.0), "up to 140 N"),
        (lambda g: g.move(0.09), "opens from 0 to 0.08 m, not 0.09 m"),
        (lambda g: g.move(-0.01), "opens from"),
    ],
)
def test_commands_that_it_cannot_follow_are_refused_and_change_nothing(command, message):
    cell, robot, control, gripper = panda_cell(cube=False)
    before = gripper.get_state()
    with pytest.raises(GripperError, match=message):
        command(gripper)
    assert gripper.get_state() == before


def test_a_robot_whose_description_has_none_has_no_gripper():
    with pytest.raises(RobotError, match="has no gripper"):
        TwoFingerGripper(Robot(replace(panda(), gripper=None)))


def test_nothing_but_motors_and_friction_acts_between_finger_and_cube(grip):
    cell, robot, control, gripper = grip
    assert cell.model.neq == 0
    kinds = {int(t) for t in cell.model.actuator_trntype}
    assert kinds == {int(mujoco.mjtTrn.mjTRN_JOINT)}


@pytest.mark.parametrize("force", [20.0, 50.0, 100.0])
def test_at_rest_each_finger_presses_with_the_commanded_force(grip, force):
    cell, robot, control, gripper = grip
    gripper.close(force)
    cell.step(1000)
    for finger in ("left_finger", "right_finger"):
        pressed = cell.contacts.between(f"panda/{finger}", "cube").normal
        assert pressed == pytest.approx(force, rel=0.05)


def test_width_and_forces_are_composers_observables(grip):
    cell, robot, control, gripper = grip
    gripper.observables.enable_all()
    environment = composer.Environment(
        composer.NullTask(cell.arena), strip_singleton_obs_buffer_dim=True, random_state=0
    )
    environment.reset()
    gripper.close(50.0)
    for _ in range(600):
        seen = environment.step(np.zeros(cell.model.nu)).observation
    key = "panda/two_finger_gripper/"
    np.testing.assert_allclose(seen[f"{key}forces"], 50.0, rtol=0.05)
    assert seen[f"{key}width"] == pytest.approx(0.05, abs=1e-3)  # the cube's edge
