"""The planned path of a tool is a line in the scene while its arm moves."""

import numpy as np
import pytest

from bt_manip.behaviours import Hover, MoveToConfiguration, Reach, RemoveObject, SpawnObject
from bt_manip.bt import Sequence, Sleep
from bt_manip.runner import RunObserver
from bt_manip_view.page import overlay_panel
from bt_manip_view.page.overlay_panel import FORCE_SCALE

READY = "0;-0.4;0;-2.2;0;1.8;0.8"

PATH = "/planned path of panda"


class Watch(RunObserver):
    """Keeps after each tick whether the arm moved, the shown lines of its path, and its tool."""

    def __init__(self, page, scene):
        self.page, self.scene, self.seen = page, scene, []

    def run_started(self, run):
        self.robot, self.arm = run.station.robot, run.station.arm

    def after_tick(self):
        self.page.refresh(now=True)
        tool = self.robot.tool_pose.translation.copy()
        self.seen.append((self.arm.moving, self.scene.segments(PATH), tool))


def moves():
    return Sequence("root", MoveToConfiguration("move", configuration=READY), Sleep(msec=30))


def test_the_path_is_drawn_from_begin_to_end_of_a_motion_and_removed(make_run, page, client, scene):
    watch = Watch(page, scene)
    make_run(moves()).execute([page, watch])
    moving = [(points, tool) for is_moving, points, tool in watch.seen if is_moving]
    at_rest = [points for is_moving, points, _ in watch.seen if not is_moving]
    assert len(moving) > 20 and all(points is not None for points, _ in moving)
    assert len(at_rest) > 2 and all(points is None for points in at_rest)
    points = moving[0][0]
    assert points.shape == (49, 2, 3)  # between the 50 points of a path
    corners = np.concatenate([points[:, 0], points[-1:, 1]])
    assert np.linalg.norm(corners[-1] - watch.seen[-1][2]) < 2e-3
    spacing = np.linalg.norm(np.diff(corners, axis=0), axis=1).max()
    for _, tool in moving:
        assert np.linalg.norm(corners - tool, axis=1).min() < spacing / 2 + 2e-3
    assert "panda: " not in client.text()


def test_no_path_is_computed_without_a_page_or_where_it_is_hidden(
    make_run, page, connect, monkeypatch
):
    class Refresh(RunObserver):
        def after_tick(self):
            page.refresh(now=True)

    monkeypatch.setattr(overlay_panel, "tool_path", pytest.fail)
    make_run(moves()).execute([page, Refresh()])
    connect("page").set("checkbox", "Planned paths", False)
    watch = Watch(page, connect())
    make_run(moves()).execute([page, watch])
    assert all(points is None for _, points, _ in watch.seen)


def test_the_path_of_a_motion_between_runs_is_drawn(make_run, page, client, scene):
    station = make_run(moves()).station
    page.begin_idle(station)
    station.arm.move_to_configuration(np.array([0, 0.3, 0, -1.8, 0, 2.1, 0.8]))
    page.refresh(now=True)
    assert scene.segments(PATH) is not None
    assert "panda: " in client.text()


def test_the_force_on_an_object_at_rest_is_its_weight(make_run, page, client, scene):
    client.set("checkbox", "Contact forces", True)
    run = make_run(Sequence("root", SpawnObject(object="{cube}"), Sleep(msec=300)))
    run.execute([page])
    cell = run.station.cell
    weight = 9.81 * cell.model.body_subtreemass[cell.body_id("cube")]
    lines = scene.segments("/contact forces")
    force = (lines[:, 1] - lines[:, 0]).sum(axis=0) / FORCE_SCALE
    np.testing.assert_allclose(force, (0.0, 0.0, weight), atol=0.02 * weight)
    client.set("checkbox", "Contact forces", False)
    page.refresh(now=True)
    assert scene.segments("/contact forces") is None


def test_checked_grasps_are_drawn_at_the_object_with_the_chosen_one_apart(
    make_run, page, client, scene
):
    client.set("checkbox", "Grasps", True)
    seen = []

    class Look(RunObserver):
        def after_tick(self):
            page.refresh(now=True)
            shown = scene.segments("/grasps of panda/chosen")
            position = cell.pose("cube").translation if "cube" in cell.entities else None
            seen.append((shown, position))

    run = make_run(
        Sequence(
            "root", SpawnObject(object="{cube}"), Hover(object="cube"), Reach(object="cube"),
            RemoveObject(object="cube"), Sleep(msec=30),
        )
    )  # fmt: skip
    cell = run.station.cell
    run.execute([page, Look()])
    drawn = [one for one in seen if all(part is not None for part in one)]
    assert drawn and seen[-1][0] is None
    for shown, position in drawn:
        assert shown.shape == (4, 2, 3)
        (first, second) = shown[:2, 0]
        np.testing.assert_allclose((first + second) / 2.0, position, atol=0.02)
        assert np.linalg.norm(first - second) == pytest.approx(0.05, abs=2e-3)  # its edge
        assert (shown[3, 1] - position)[2] > 0.05  # from above
    assert run.station.first.grasp_planner.checked.chosen is not None
    client.set("checkbox", "Grasps", False)
    page.refresh(now=True)
    assert scene.segments("/grasps of panda/chosen") is None


def test_frames_are_shown_on_request(make_run, page, client, scene):
    make_run(moves()).execute([page])
    client.set("checkbox", "Frames", True)
    bodies = [node for name, node in scene.see().nodes.items() if name.count("/") == 2]
    shown = [node["show_axes"] for node in bodies if "show_axes" in node]
    assert len(shown) > 10 and all(shown)
