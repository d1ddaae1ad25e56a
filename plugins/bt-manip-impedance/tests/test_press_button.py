"""A button is pressed, counted and released."""

import re
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.behaviours import CloseGripper, Hover
from bt_manip.bt import NodeStatus, Tree
from bt_manip.cell import Cell
from bt_manip.testing import play
from bt_manip_impedance import Press, PushButton, WasPressed


@pytest.fixture(scope="module")
def over_the_button(parts):
    """Return a station with the closed gripper over the button, and its state."""
    station = build_station(parts, scene=parts.scenes.create("press_button"))
    play(station, CloseGripper(force=10.0), Hover(object="button", height=0.06))
    return station, station.get_state()


@pytest.fixture
def press(over_the_button, monkeypatch):
    """Press under a controller; give why it failed, the lines, and depths and progress."""

    def press(controller, **ports):
        (station, state), moves, course = over_the_button, [], []
        station.set_state(state)
        station.controllers.switch(controller)
        arm, button = station.arm, station.cell.find("button")
        move = arm.move_linear
        monkeypatch.setattr(
            arm, "move_linear", lambda T, **given: moves.append((T, given)) or move(T, **given)
        )
        tree = Tree(Press(object="button", **ports), clock=station.clock)
        tree.setup(**station.infrastructure)
        pressed = WasPressed(object="button", released=True)
        pressed.setup(**station.infrastructure)
        while (status := tree.tick()) is NodeStatus.RUNNING:
            station.cell.step(10)
            course.append((button.depth, pressed.progress()))
        assert button.depth < 1e-4
        reason = tree.failure_reason() if status is NodeStatus.FAILURE else ""
        return reason, moves, np.array(course).T

    return press


def test_a_compliant_arm_presses_the_button_by_as_much_and_as_long_as_asked(press, over_the_button):
    given = {"hold": 0.1, "depth": 0.017, "speed": 0.2}
    reason, moves, (depths, progress) = press("cartesian_impedance", **given)
    assert not reason
    assert 0.1 <= 0.01 * sum(depths > 0.95 * 0.008) < 0.3  # [s] held down
    top = over_the_button[0].cell.pose("button").translation + (0.0, 0.0, 0.03)
    for (T, given), height in zip(moves, (-0.017, 0.03), strict=True):
        assert T.translation == pytest.approx(top + (0.0, 0.0, height))
        assert T.rotation[:, 2] == pytest.approx((0.0, 0.0, -1.0), abs=1e-3)
        assert given == {"speed": 0.2, "contact": True}
    first = np.argmax(depths > 1e-3)
    assert progress[:first].max() < 0.5 and progress[-1] == pytest.approx(1.0, abs=0.01)
    assert np.diff(progress[first:]).min() > -0.01


def test_a_stiff_arm_exceeds_the_force_and_one_that_is_not_moved_far_enough_does_not_press(press):
    reason, _, _ = press("computed_torque", hold=0.1)
    assert "at most 40 N are allowed; a stiff controller" in reason
    reason, _, _ = press("cartesian_impedance", depth=0.004, speed=0.2)
    down, expected = re.search(
        r"is down by (.*) of (.*) mm when the arm has stopped", reason
    ).groups()
    assert 1.0 < float(down) < 7.6 and expected == "8.0"


def test_a_press_is_by_default_as_the_reference_says():
    press = Press(object="button")
    assert (press.depth, press.hold, press.speed, press.max_force) == (0.016, 0.3, 0.1, None)


def test_progress_is_that_of_the_nearest_tool_and_of_the_cap():
    cell = Cell()
    cell.add(PushButton(travel=0.01), spatial.pose((0.3, -0.2, 0.1)), name="button")
    tools = [
        SimpleNamespace(tool_pose=spatial.pose(at)) for at in ((0.3, -0.1, 0.15), (0.0, 0.5, 0.3))
    ]
    pressed = WasPressed("pressed", object="button", released=True)
    pressed.setup(cell=cell, robots={n: SimpleNamespace(robot=t) for n, t in enumerate(tools)})
    cell.data.qpos[0] = 0.004
    near = 1.0 - np.tanh(np.hypot(0.1, 0.15 - 0.132) / 0.2)  # the cap's top is 3.2 cm high
    assert pressed.progress() == pytest.approx(0.4 * near + 0.4 * 0.4)
    cell.find("button").pressed_at = 0.1
    assert pressed.progress() == pytest.approx(0.8 + 0.2 * 0.6)
    for depth, met in ((0.9e-4, 1), (1.1e-4, 0)):
        cell.data.qpos[0] = depth
        assert (pressed.why_not() == "") == met
