"""MuJoCo's actuators open and close two fingers, and hold a cube."""

import numpy as np
import pytest

from bt_manip.grippers import NativeTwoFingerGripper
from bt_manip.robots import GripperError, Robot
from tests.control.conftest import panda_cell

from .test_linked_fingers import FILE
from .test_two_finger import step_until


@pytest.fixture
def grip():
    return panda_cell(make_gripper=NativeTwoFingerGripper)


@pytest.mark.parametrize("force", [20.0, 50.0])
def test_it_holds_with_the_asked_force(grip, force):
    cell, robot, control, gripper = grip
    gripper.close(force)
    assert gripper.moving and gripper.gripping
    step_until(cell, lambda: gripper.steady)
    assert not gripper.moving and gripper.held == ("cube",)
    assert gripper.forces == pytest.approx((force, force), rel=0.03)


@pytest.mark.parametrize("offset", [0.004, -0.01])
def test_a_held_cube_does_not_creep_and_is_released(offset):
    cell, robot, control, gripper = panda_cell(offset, make_gripper=NativeTwoFingerGripper)
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    cell.remove("post")  # now friction alone holds it
    cell.step(50)
    before = cell.pose("cube").translation
    cell.step(500)
    assert np.abs(cell.pose("cube").translation - before).max() < 1e-3
    gripper.open()
    step_until(cell, lambda: gripper.is_open, 2.0)
    cell.step(200)
    assert gripper.width == pytest.approx(0.08, abs=1e-3)
    assert not gripper.held and cell.pose("cube").translation[2] < before[2] - 0.01


def test_without_an_object_it_has_closed_on_nothing():
    cell, robot, control, gripper = panda_cell(cube=False, make_gripper=NativeTwoFingerGripper)
    gripper.close()
    step_until(cell, lambda: gripper.closed_on_nothing)
    cell.step(300)
    assert not gripper.steady and not gripper.moving


def test_signals_of_many_steps_are_those_of_single_steps(grip):
    cell, robot, control, gripper = grip
    gripper.close()
    kept, single = gripper.get_state(), []
    for _ in range(70):
        cell.step()
        single.append(cell.data.ctrl[gripper.mechanism.ctrl_adr])
    after = gripper.get_state()
    gripper.set_state(kept)
    rows = np.concatenate([gripper.signals(30), gripper.signals(40)])
    assert rows.tobytes() == np.array(single).tobytes()
    assert gripper.get_state()["ramp"] == after["ramp"]


def test_fingers_of_a_mechanism_are_refused_with_the_reason():
    from bt_manip.robots import read_description

    with pytest.raises(GripperError, match="these follow a mechanism"):
        Robot(read_description(FILE), gripper=NativeTwoFingerGripper)
