"""What a person sees and does on the page of a run (``--view``)."""

import time

import mujoco
import numpy as np
import pytest

from bt_manip.runner import RunRequest, find_tree, prepare
from bt_manip.viewer import render

from .conftest import Program, Window, wait_until
from .framing import check_framing

CAMERA = """
    () => {
        const { nodeRefFromName, camera } = __viserMutable, world = nodeRefFromName[''];
        camera.updateMatrixWorld();
        world.updateMatrixWorld();
        return world.matrixWorld.clone().invert().multiply(camera.matrixWorld).toArray();
    }
"""
"""Gives the pose of the camera in the world, a 4x4 matrix by columns."""


@pytest.fixture(scope="module")
def program(start) -> Program:
    return start("run", "pick_place", "--cycles", "0", "--seed", "3", "--view", "--real-time", "1")


@pytest.fixture
def paused(window) -> Window:
    window.press("Pause")
    window.wait_for_text("s: paused")
    return window


def test_the_robot_is_drawn_as_a_camera_of_mujoco_there_sees_it(opengl, paused, parts):
    shown = paused.scene("picking")
    share = (abs(shown - paused.scene_without("/panda")).max(axis=2) > 20).mean()
    source = find_tree("pick_place", {"pick_place": parts.trees.get("pick_place")})
    run = prepare(RunRequest(source, seed=3, cycles=0), parts)
    cell, due = run.station.cell, paused.time()
    run.execute(stop=lambda: cell.time >= due - 1e-3)
    pose = np.array(paused.evaluate(CAMERA)).reshape(4, 4).T
    camera = cell.model.camera("overview")
    camera.pos[:] = pose[:3, 3]
    mujoco.mju_mat2Quat(camera.quat, np.ascontiguousarray(pose[:3, :3]).ravel())
    camera.fovy[:] = paused.evaluate("() => __viserMutable.camera.fov")
    height, width = shown.shape[:2]
    expected = render(cell, width=width, height=height).astype(int)
    cell.model.geom_rgba[_robot(cell.model)] = 0.0
    cell.model.geom_matid[_robot(cell.model)] = -1
    without = render(cell, width=width, height=height).astype(int)
    drawn = (abs(expected - without).max(axis=2) > 20).mean()
    assert share == pytest.approx(drawn, rel=0.5)  # shadows differ


def _robot(model):
    names = [model.body(body).name for body in model.geom_bodyid]
    return [geom for geom, name in enumerate(names) if name.startswith("panda/")]


def test_all_that_the_task_is_about_is_inside_the_picture_at_any_size_of_the_window(window):
    check_framing(window, "pick_place")


def test_things_have_their_textures(window):
    script = """
        name => {
            let width = 0;
            __viserMutable.nodeRefFromName[name].traverse((mesh) => {
                width = Math.max(width, mesh.material?.map?.image?.width ?? 0);
            });
            return width;
        }
    """
    wait_until(lambda: window.evaluate(script, "/table") == 256)


def test_the_picture_of_a_chosen_camera_is_over_the_scene(opengl, window):
    picture = window.page.locator("img.picture")
    assert not picture.is_visible()
    window.choose("Camera", "panda/wrist")
    wait_until(lambda: picture.is_visible() and picture.evaluate("one => one.naturalWidth") == 320)
    window.keep("camera")
    window.choose("Camera", "none")
    wait_until(lambda: not picture.is_visible())


def test_the_tree_follows_the_run_with_statuses_and_reasons(window):
    window.wait_for_tree("▶ (Hover|Reach|Lift|Drop)")
    window.wait_for_tree("✓ SpawnObject +'cube' at")
    window.wait_for_tree("✗ IsHolding +the gripper holds nothing, not 'cube'")
    window.wait_for_tree(r"▶ (Hover|Reach|Lift|Drop) .*\d\.\d\d s$")


def test_the_speed_can_be_changed(window):
    def has_slowed_down() -> bool:
        start, before = time.monotonic(), window.time()
        time.sleep(2.0)
        after, elapsed = window.time(), time.monotonic() - start
        return 0.0 < after - before < 0.1 * elapsed + 0.1

    window.choose("Speed", "1/10")
    wait_until(has_slowed_down)  # the page may show it later
    slow = window.time()
    window.choose("Speed", "1")
    wait_until(lambda: window.time() > slow + 1.0)


def test_a_breakpoint_in_the_margin_pauses_where_its_node_starts(window):
    window.set_breakpoint("Lift")
    try:
        window.wait_for_text(r"s: paused at attempt/pick/Lift::\d+")
        assert "▶ Lift" in window.tree()
    finally:
        window.set_breakpoint("Lift")
    wait_until(lambda: not window.page.locator(".margin.set").count())


def test_a_click_selects_an_arrow_folds_and_a_double_click_shows_a_sub_tree_alone(window):
    window.select("Grasp")
    window.wait_for_text("attempt/pick/Grasp")
    window.wait_for_text("Action Grasp, ")
    window.node("pick").locator(".fold").click(force=True)
    wait_until(lambda: "Grasp" not in window.tree())
    window.node("pick").locator(".fold").click(force=True)
    wait_until(lambda: "Grasp" in window.tree())
    window.node("pick").locator(".name").dblclick(force=True)
    wait_until(lambda: window.tree().split()[1] == "pick")
    window.press("⬑ Whole tree")
    wait_until(lambda: "SpawnObject" in window.tree())


def test_the_keys_are_those_of_a_file_tree(window):
    keys = window.page.keyboard
    window.select("pick")
    for key, selected in {
        "ArrowLeft": "pick",
        "ArrowRight": "pick",
        "ArrowDown": "Sequence",
    }.items():
        keys.press(key)
        wait_until(lambda name=selected: name in window.page.locator(".line.chosen").inner_text())
    keys.press("b")
    window.page.locator(".line.chosen .margin.set").wait_for()
    keys.press("b")
    wait_until(lambda: not window.page.locator(".margin.set").count())
    keys.press("/")
    keys.type("drop")
    wait_until(lambda: "Lift" not in window.tree() and "Drop" in window.tree())
    keys.press("Escape")
    wait_until(lambda: "Lift" in window.tree())


def test_the_time_line_shows_the_last_minute_while_the_run_is_paused(paused):
    line = paused.page.get_by_role("slider", name="Timeline")
    box = line.bounding_box()
    now = paused.time()
    line.click(position={"x": box["width"] / 2, "y": box["height"] / 2})
    paused.button("Back to now").wait_for()
    wait_until(lambda: float(line.get_attribute("aria-valuenow")) < now - 0.1)
    paused.keep("look_back")
    paused.press("Back to now")
    wait_until(lambda: float(line.get_attribute("aria-valuenow")) == pytest.approx(now, abs=0.01))


def test_log_blackboard_and_plot_are_in_tabs(window):
    window.open_tab("Log")
    window.wait_for_text("cube added")
    window.wait_for_text(r"Grasp: fingers press with")
    assert "IsHolding: " not in window.text()
    window.page.get_by_label("condition").check()
    window.wait_for_text("IsHolding: the gripper holds nothing")
    window.page.get_by_label("condition").uncheck()
    window.open_tab("Blackboard")
    window.wait_for_text("cube\\s+auto")
    window.open_tab("Tracking error")
    plot = window.page.locator("canvas.plot")
    plot.wait_for()
    window.page.wait_for_timeout(500)
    drawn = plot.evaluate(
        "canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data"
        ".filter((value, index) => index % 4 == 3 && value > 0).length"
    )
    assert drawn > 100
    window.keep("plot")
    window.open_tab("Log")


def test_stop_ends_the_run_with_the_exit_code_of_an_interrupted_one(program, window):
    window.press("Stop")
    window.wait_for_text("s: stopped")
    program.wait_for("stays up")
    assert program.interrupt() == 130
    assert not program.errors.read_text()
