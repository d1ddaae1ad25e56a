"""The planned path of a tool is a line in the scene while its arm moves."""

import numpy as np
import pytest

from bt_manip.arm.tool_path import PATH_SAMPLES
from bt_manip.behaviours import MoveToConfiguration
from bt_manip.bt import Sequence, Sleep
from bt_manip.runner import RunObserver
from bt_manip.viewer.page import path_panel

READY = "0;0.3;0;-1.8;0;2.1;0.8"


@pytest.fixture
def panel(page):
    (panel,) = [panel for panel in page._panels if type(panel).__name__ == "PathPanel"]
    return panel


@pytest.fixture
def browser(page, monkeypatch):
    """Let a page be open."""
    monkeypatch.setattr(type(page), "is_open", True)


class Watch(RunObserver):
    """Draws after each tick; keeps whether the arm moved, and the line and its points."""

    def __init__(self, panel):
        self.panel, self.seen = panel, []

    def run_started(self, run):
        self.robot = run.station.robot
        self.arm = next(iter(run.station.robots.values())).arm

    def after_tick(self):
        self.panel.draw()
        line = self.panel._lines.get("panda")
        points = None if line is None else line.points.copy()
        self.seen.append((self.arm.moving, points, self.robot.tool_pose.translation.copy()))


def moves():
    return Sequence("root", MoveToConfiguration("move", configuration=READY), Sleep(msec=30))


@pytest.mark.usefixtures("browser")
def test_the_path_is_drawn_from_begin_to_end_of_a_motion_and_removed(make_run, page, panel):
    watch = Watch(panel)
    make_run(moves()).execute([page, watch])
    moving = [(points, tool) for is_moving, points, tool in watch.seen if is_moving]
    at_rest = [points for is_moving, points, _ in watch.seen if not is_moving]
    assert len(moving) > 20 and all(points is not None for points, _ in moving)
    assert len(at_rest) > 2 and all(points is None for points in at_rest)
    points = moving[0][0]
    assert points.shape == (PATH_SAMPLES - 1, 2, 3)
    corners = np.concatenate([points[:, 0], points[-1:, 1]])
    assert np.linalg.norm(corners[-1] - watch.seen[-1][2]) < 2e-3
    spacing = np.linalg.norm(np.diff(corners, axis=0), axis=1).max()
    for _, tool in moving:
        assert np.linalg.norm(corners - tool, axis=1).min() < spacing / 2 + 2e-3
    assert panel._html.content == ""


def test_nothing_is_computed_without_a_page(make_run, page, panel, monkeypatch):
    monkeypatch.setattr(path_panel, "tool_path", pytest.fail)
    make_run(moves()).execute([page, Watch(panel)])


@pytest.mark.usefixtures("browser")
def test_the_path_can_be_hidden(make_run, page, panel):
    panel._checkbox.value = False
    watch = Watch(panel)
    make_run(moves()).execute([page, watch])
    assert all(points is None for _, points, _ in watch.seen)


@pytest.mark.usefixtures("browser")
def test_the_path_of_a_motion_between_runs_is_drawn(make_run, page, panel):
    station = make_run(moves()).station
    page.begin_idle(station)
    (robot,) = station.robots.values()
    robot.arm.move_to_configuration(np.array([0, 0.3, 0, -1.8, 0, 2.1, 0.8]))
    panel.draw()
    assert "panda" in panel._lines
