"""MuJoCo's actuators open and close two fingers, and hold a cube."""

from types import SimpleNamespace

import numpy as np
import pytest

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


def test_signals_past_the_end_of_a_plan_are_its_last():
    planned = np.arange(6.0).reshape(3, 2)
    hand = SimpleNamespace(_planned=lambda: planned, _index=1, advance=lambda steps: None)
    rows = NativeTwoFingerGripper.signals(hand, 4)
    assert rows.tolist() == planned[[1, 2, 2, 2]].tolist()


@pytest.mark.parametrize(("start", "aim"), [(0.04, 0.01), (0.01, 0.04)])
def test_the_planned_damping_is_that_of_the_speed_of_the_reference(start, aim):
    s, dt = np.linspace(start, aim, 31), 0.01
    hand = SimpleNamespace(
        _signals=None, _path=lambda: s, _start=start, _aim=aim, _rate=0.1,
        _a=np.array([1.0, -1.0]), _b=np.zeros(2), _k=0.0, _d=2.0,
    )  # fmt: skip
    velocity = np.append(np.diff(s) / dt, 0.0)
    np.testing.assert_allclose(
        NativeTwoFingerGripper._planned(hand), 2.0 * np.outer(velocity, [1.0, -1.0]), atol=1e-9
    )


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
