"""Between runs, sliders, a handle and buttons move the arm through its own motions."""

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.bt import Sleep
from bt_manip.scenes import two_arms
from bt_manip_view import Page
from bt_manip_view.page.jog_panel import JogPanel

HANDLE = "/jog/panda"


@pytest.fixture
def page():
    def make(page):
        page.jog = JogPanel(page, pytest.fail)
        return page.jog

    page = Page({"jog": make}, port=0, speed=None)
    yield page
    page.close()


@pytest.fixture
def run(make_run):
    return make_run(Sleep("rest", msec=30))


@pytest.fixture
def station(page, run):
    page.begin_idle(run.station)
    return run.station


class User:
    """Does what a person does on an open page."""

    def __init__(self, page, client, scene, station):
        self.page, self.client, self.scene, self._station = page, client, scene, station

    @property
    def sliders(self):
        return [one for one in self.client.see().elements.values() if one["kind"] == "slider"]

    @property
    def handle(self):
        return self.scene.see().nodes[HANDLE]

    def set_slider(self, i, value):
        self.client.set("slider", self.sliders[i]["label"], value)

    def press(self, command):
        self.client.send(self.client.see().uid("button_group"), "click", command)

    def wait(self, seconds=3.0):
        for _ in range(round(seconds / 0.01)):
            self.page.tick()
            self._station.cell.step(10)
        self.page.refresh(now=True)


@pytest.fixture
def user(page, client, scene, station):
    return User(page, client, scene, station)


def test_a_slider_moves_its_joint_slowly_and_no_other_and_stays_where_it_was_put(user, station):
    start = station.robot.q.copy()
    user.set_slider(1, -0.4)
    fastest = 0.0
    for tick in range(300):
        user.wait(0.01)
        fastest = max(fastest, float(np.abs(station.arm.v).max()))
        if tick == 50:
            assert user.sliders[1]["value"] == -0.4 and user.page.jog.moved
    expected = start.copy()
    expected[1] = -0.4
    assert station.robot.q == pytest.approx(expected, abs=2e-3)
    assert 0.1 < fastest < 0.26 * station.arm.model.limits.velocity[1]


def test_sliders_follow_the_measured_joints(user, station):
    station.arm.move_to_configuration([0.3, -0.6, 0.2, -2.0, 0.1, 1.7, 0.5])
    user.wait(2.0)
    shown = [slider["value"] for slider in user.sliders]
    assert shown == pytest.approx(station.robot.q, abs=2e-3)
    assert shown[0] == pytest.approx(0.3, abs=2e-3)


def test_a_target_in_collision_is_refused_with_the_reason(user, station):
    start = station.robot.q.copy()
    user.set_slider(1, 1.7)  # into the table
    user.wait(0.5)
    assert not station.arm.busy
    assert station.robot.q == pytest.approx(start, abs=1e-3)
    assert "table" in user.client.text() and not user.page.jog.moved


def test_the_handle_moves_the_tool(user, station):
    goal = station.arm.model.pose(station.arm.q).translation + [0.05, 0.1, 0.05]
    user.scene.see().drag(HANDLE, goal, start=True)
    user.scene.drag(HANDLE)
    user.wait()
    reached = station.arm.model.pose(station.robot.q).translation
    assert reached == pytest.approx(goal, abs=2e-3)


def test_an_unreachable_handle_is_refused_and_returns(user, station):
    user.scene.see().drag(HANDLE, [3.0, 0.0, 1.0], start=True)
    user.wait(0.2)
    assert "unreachable" in user.client.text()
    assert user.handle["position"] == (3.0, 0.0, 1.0)  # still held
    user.scene.drag(HANDLE)
    user.wait(0.2)
    tool = station.arm.model.pose(station.arm.q).translation
    assert user.handle["position"] == pytest.approx(tool, abs=1e-3)


def test_the_gripper_closes_and_opens(user, station):
    user.press("Close")
    user.wait(1.0)
    assert station.gripper.closed_on_nothing
    user.press("Open")
    user.wait(1.0)
    assert station.gripper.is_open


def test_nothing_can_be_jogged_while_a_tree_runs(user, page, run, station):
    def offered():
        buttons = user.client.see().find("button_group"), user.client.find("text", "Save as")
        return [
            *(not one["disabled"] for one in user.sliders), user.handle["visible"],
            *(one["visible"] for one in buttons),
        ]  # fmt: skip

    q = station.robot.q.copy()
    user.set_slider(0, 0.5)
    run.execute([page])
    assert not any(offered())
    page.begin_idle(station)
    user.wait(0.5)
    assert station.robot.q == pytest.approx(q, abs=1e-3)
    assert all(offered())


def test_another_cell_with_the_same_robot_keeps_its_nodes(page, station, scene, parts):
    def change(station):
        """Return the names of the nodes that another cell adds or removes."""
        page.begin_idle(station)
        kinds = "FrameMessage", "MeshMessage", "GlbMessage", "RemoveSceneNodeMessage"
        changed = {m["name"] for m in scene.read() if m["type"] in kinds}
        return {name for name in changed if not name.startswith("/jog")}

    assert any(name.startswith("/panda/") for name in change(station))
    assert not change(build_station(parts, seed=1))
    assert any(name.startswith("/left/") for name in change(build_station(parts, scene=two_arms())))
