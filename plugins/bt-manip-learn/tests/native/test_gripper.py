"""MuJoCo's actuators open and close two fingers, and hold a cube."""

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.robots import GripperError, Robot, panda
from bt_manip_learn import NativeTwoFingerGripper
from tests.support.arms import panda_cell, step_until


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


def test_a_held_cube_does_not_creep_and_is_released():
    cell, robot, control, gripper = panda_cell(-0.01, make_gripper=NativeTwoFingerGripper)
    gripper.close()
    step_until(cell, lambda: gripper.steady)
    cell.remove("post")  # now friction alone holds it
    cell.step(50)
    before = cell.pose("cube").translation
    cell.step(500)
    assert np.abs(cell.pose("cube").translation - before).max() < 1e-3
    push = cell.data.xfrc_applied[cell.body_id("cube"), :3]
    push[:] = 10.0 * robot.tool_pose.rotation[:, 1]  # [N] along the closing direction
    fingers = cell.model.jnt_qposadr[cell.model.actuator_trnid[gripper.mechanism.ctrl_adr, 0]]
    for _ in range(100):
        cell.step()
        assert abs(np.subtract(*cell.data.qpos[fingers])) < 4e-4  # coupled
    push[:] = 0.0
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


@pytest.fixture
def described(tmp_path):
    """Give a function that makes a Panda with other lines in the file of its fingers' travel."""

    def described(**lines):
        description, path = panda(), tmp_path / "finger_travel.toml"
        parameters = description.gripper.parameters
        text = Path(parameters["travel"]).read_text()
        for key, value in lines.items():
            text, count = re.subn(f"^{key} = .*", f"{key} = {value}", text, flags=re.MULTILINE)
            assert count == 1
        path.write_text(text)
        gripper = replace(description.gripper, parameters={**parameters, "travel": str(path)})
        return Robot(replace(description, gripper=gripper), gripper=NativeTwoFingerGripper)

    return described


def test_fingers_that_follow_a_mechanism_are_refused_with_the_reason(described):
    with pytest.raises(GripperError, match="these follow a mechanism"):
        described(mass=0.1)


def test_loops_with_two_poles_at_150_per_second_follow_ramps_and_press_at_their_end(described):
    """The second finger moves away from its joint, and twice as far, by description."""
    robot = described(min_width=0.016, polynomials="[[0.003, 1.0], [-0.005, -2.0]]")
    cell = Cell()
    cell.add(robot)
    model, gripper = cell.model, robot.gripper
    motors = gripper.mechanism.ctrl_adr
    dofs = model.jnt_dofadr[model.actuator_trnid[motors, 0]]
    kp, kd = -model.actuator_biasprm[motors, 1:3].T
    slopes, offsets = np.array([1.0, -2.0]), np.array([0.003, -0.005])
    loops = np.transpose([kp, kd]) / slopes[:, np.newaxis] ** 2  # of the fingers, not the joints
    for m, c, (p, d) in zip(model.dof_M0[dofs], model.dof_damping[dofs], loops, strict=True):
        assert np.roots([m, c + d, p]) == pytest.approx([-150.0, -150.0], rel=1e-4)
    coupling = model.eq_data[model.equality("panda/finger_synchrony").id, :5]
    q = 0.01
    assert offsets[0] + np.polyval(coupling[::-1], q) == pytest.approx(offsets[1] - 2.0 * q)
    for start, aim in ((0.04, 0.01015), (0.01015, 0.0312)):  # 298.5 and 210.5 steps at 0.1 m/s
        gripper.move(2 * aim)
        t, way = 1e-3 * np.arange(400)[:, np.newaxis], abs(aim - start)
        s = start + np.sign(aim - start) * np.minimum(0.1 * t, way)
        v = np.sign(aim - start) * np.where(0.1 * t < way, 0.1, 0.0)
        steps = int(np.ceil(way / 1e-4))
        rows = [gripper.signals(steps - 1)]
        assert gripper.moving
        rows.append(gripper.signals(1))
        assert not gripper.moving
        rows.append(gripper.signals(400 - steps))
        expected = (kp * (s - offsets) + kd * v) / slopes  # no force where joints follow
        np.testing.assert_allclose(np.concatenate(rows), expected, atol=1e-9)
    gripper.move(0.08)
    gripper.signals(31)
    gripper.stop()
    expected = kp * (0.0312 + 31e-4 - offsets) / slopes
    np.testing.assert_allclose(gripper.signals(1), [expected], atol=1e-9)
    assert not gripper.moving
    gripper.close(30.0)  # half as much again beyond the closed fingers
    for _ in range(2):
        end = gripper.signals(1000)[-1]
        assert end == pytest.approx(kp * (0.008 - offsets) / slopes - 45.0 * slopes)
        gripper.stop()
    assert model.actuator_forcerange[motors].tolist() == [[-30.0, 30.0], [-60.0, 60.0]]


def test_fingers_with_more_damping_of_their_own_than_needed_get_no_more(monkeypatch):
    monkeypatch.setattr("bt_manip_learn.native.gripper._POLE", 1.0)  # [rad/s]
    cell, *_, gripper = panda_cell(cube=False, make_gripper=NativeTwoFingerGripper)
    assert not cell.model.actuator_biasprm[gripper.mechanism.ctrl_adr, 2].any()


@pytest.mark.parametrize(
    ("lag", "forces", "steady"),
    [
        (0.0181, (50.0, 40.6), True),
        (0.0179, (50.0, 40.6), False),
        (0.0181, (50.0, 39.4), False),
        (0.0181, (69.0, 50.6), True),
        (0.0181, (69.0, 51.4), False),
    ],
)
def test_a_grip_is_steady_at_the_force_with_references_well_beyond_the_object(lag, forces, steady):
    # 50 N at 10 kN/m are 5 mm; 50 ms at 80 mm/s are 4 mm, of both fingers.
    hand = SimpleNamespace(
        state="gripping", closed_on_nothing=False, width=0.03, _reference=0.5 * (0.03 - lag),
        _asked=50.0, _k=1e4, _speed=0.08, forces=forces,
    )  # fmt: skip
    assert NativeTwoFingerGripper.steady.fget(hand) == steady
    hand._open = 0.08
    states = ("still", 0.0396, True), ("still", 0.0394, False), ("moving", 0.0396, False)
    for hand.state, hand._reference, is_open in states:
        assert NativeTwoFingerGripper.is_open.fget(hand) == is_open
