"""Between runs, sliders, a handle and buttons move the arm through its own motions."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.bt import Sleep, Tree
from bt_manip.exceptions import BtManipError
from bt_manip.runner import Run, RunRequest, TreeSource
from bt_manip.scenes import two_arms
from bt_manip.viewer import Page
from bt_manip.viewer.page import JogPanel


@pytest.fixture
def saved():
    return {}


@pytest.fixture
def page(saved):
    def save(name, q):
        if not name:
            raise BtManipError("it has no name")
        saved[name] = q
        return f"'{name}' is saved"

    page = Page({"jog": lambda page: JogPanel(page, save)}, port=0, speed=None)
    yield page
    page.close()


@pytest.fixture
def station(parts):
    return build_station(parts)


@pytest.fixture
def jog(page, station):
    page.begin_idle(station)
    return page._panels[-1]


def run_coroutine(coroutine):
    """Run a callback as viser's event loop does."""
    with pytest.raises(StopIteration):
        coroutine.send(None)


def use(element, event, value):
    """Use an input as a browser does."""
    element._gui.receive(json.dumps({"id": element.uid, "event": event, "value": value}))


class User:
    """Does what a person does on an open page."""

    def __init__(self, jog, station):
        self._jog, self._station, self._robot = jog, station, jog._robots[0]

    def set_slider(self, i, value):
        use(self._robot._sliders[i], "value", value)

    def drag_handle(self, position, *phases):
        handle = self._robot._handle
        handle.position = position
        for phase in phases:
            run_coroutine(self._robot._handle_moved(SimpleNamespace(phase=phase, target=handle)))

    def press(self, command):
        use(self._robot._others[0], "click", command)

    def save_as(self, name):
        use(self._robot._name, "value", name)
        use(self._robot._others[-1], "click", None)

    def wait(self, seconds=3.0):
        for i in range(round(seconds / 0.01)):
            self._jog.idle_tick()
            self._station.cell.step(10)
            if i % 10 == 0:
                self._jog.draw()

    @property
    def sliders(self):
        return [slider.value for slider in self._robot._sliders]


@pytest.fixture
def user(jog, station):
    return User(jog, station)


def test_a_slider_moves_its_joint_slowly_and_no_other(user, station):
    start = station.robot.q.copy()
    user.set_slider(1, -0.4)
    fastest = 0.0
    for _ in range(300):
        user.wait(0.01)
        fastest = max(fastest, float(np.abs(station.arm.v).max()))
    expected = start.copy()
    expected[1] = -0.4
    assert station.robot.q == pytest.approx(expected, abs=2e-3)
    assert 0.1 < fastest < 0.26 * station.arm.model.limits.velocity[1]


def test_sliders_follow_the_measured_joints(user, station):
    station.arm.move_to_configuration([0.3, -0.6, 0.2, -2.0, 0.1, 1.7, 0.5])
    user.wait(2.0)
    assert user.sliders == pytest.approx(station.robot.q, abs=2e-3)
    assert user.sliders[0] == pytest.approx(0.3, abs=2e-3)


def test_a_slider_stays_where_it_was_put_until_the_arm_is_there(user, jog):
    user.set_slider(0, 1.0)
    user.wait(0.5)
    assert user.sliders[0] == 1.0
    assert jog.moved


def test_a_target_in_collision_is_refused_with_the_reason(user, station, jog):
    start = station.robot.q.copy()
    user.set_slider(1, 1.7)  # into the table
    user.wait(0.5)
    assert not station.arm.busy
    assert station.robot.q == pytest.approx(start, abs=1e-3)
    assert "table" in jog._message.content and not jog.moved


def test_the_handle_moves_the_tool(user, station):
    goal = station.arm.model.pose(station.arm.q).translation + [0.05, 0.1, 0.05]
    user.drag_handle(goal, "start", "update", "end")
    user.wait()
    reached = station.arm.model.pose(station.robot.q).translation
    assert reached == pytest.approx(goal, abs=2e-3)


def test_an_unreachable_handle_is_refused_and_returns(user, station, jog):
    user.drag_handle([3.0, 0.0, 1.0], "start", "update")
    user.wait(0.2)
    assert "unreachable" in jog._message.content
    assert user._robot._handle.position[0] == 3.0  # still held
    user.drag_handle([3.0, 0.0, 1.0], "end")
    user.wait(0.2)
    tool = station.arm.model.pose(station.arm.q).translation
    assert user._robot._handle.position == pytest.approx(tool, abs=1e-3)


def test_the_gripper_closes_and_opens(user, station):
    user.press("Close")
    user.wait(1.0)
    assert station.gripper.closed_on_nothing
    user.press("Open")
    user.wait(1.0)
    assert station.gripper.is_open


def test_a_configuration_is_saved_by_name(user, station, jog, saved):
    user.set_slider(0, 0.5)
    user.wait()
    user.save_as("above_bin")
    user.wait(0.1)
    assert saved["above_bin"][0] == pytest.approx(0.5)
    assert station.robot.configuration("above_bin")[0] == pytest.approx(0.5)
    assert "is saved" in jog._message.content
    user.save_as("")
    user.wait(0.1)
    assert "it has no name" in jog._message.content


def test_numbers_of_no_use_have_no_effect(user, station):
    for value in (float("nan"), "far", None, 100.0):
        user.set_slider(0, value)
        user.wait(0.05)
        assert not user._robot.requests and not station.arm.busy


def test_nothing_can_be_jogged_while_a_tree_runs(user, page, station):
    tree = Tree(Sleep("rest", msec=30), clock=station.clock)
    run = Run(RunRequest(TreeSource("test", "python")), tree, station)
    user.set_slider(0, 0.5)
    run.execute([page])
    robot = user._robot
    assert not robot.requests and not robot._handle.visible
    assert all(slider.disabled for slider in robot._sliders)
    page.begin_idle(station)
    assert robot._handle.visible and not any(slider.disabled for slider in robot._sliders)


def test_another_cell_with_the_same_robot_keeps_its_nodes(page, jog, parts):
    def nodes():
        known = page.server.scene._handle_from_node_name
        return {name: id(node) for name, node in known.items() if not name.startswith("/jog")}

    before = nodes()
    page.begin_idle(build_station(parts, seed=1))
    assert nodes() == before and any(name.startswith("/panda/") for name in before)
    assert len(jog._robots) == 1
    page.begin_idle(build_station(parts, scene=two_arms()))
    assert nodes() != before and len(jog._robots) == 2
