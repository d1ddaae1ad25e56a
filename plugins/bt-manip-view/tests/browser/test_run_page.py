"""What a person sees and does on the page of a run (``--view``)."""

import time

import mujoco
import numpy as np
import pytest

from bt_manip.runner import RunRequest, find_tree, prepare
from bt_manip.viewer import render

from .conftest import SIZE, Program, Window, wait_until
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

COLOUR = "one => getComputedStyle(one).color"

RED = """
    () => {
        const one = document.body.appendChild(document.createElement("i"));
        one.style.color = "var(--red)";
        return getComputedStyle(one).color;
    }
"""
"""Gives the colour of failures."""


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
    window.wait_for_tree("no IsHolding +the gripper holds nothing, not 'cube'")
    red = window.page.evaluate(RED)
    assert red != window.node("IsHolding").locator(".name").evaluate(COLOUR)
    window.wait_for_tree(r"▶ (Hover|Reach|Lift|Drop) .*\d\.\d\d s$")


def test_keys_work_after_a_click_on_a_button_or_a_box(window):
    focused = "() => document.activeElement.type ?? document.activeElement.tagName"
    keys = window.page.keyboard
    for used in (window.button("Pause"), window.page.get_by_label("Follow")):
        used.click(force=True)
        keys.press("/")
        assert window.page.evaluate(focused) == "search"
        keys.press("Escape")
    window.page.get_by_label("Follow").click(force=True)
    window.wait_for_text("s: paused")
    window.button("Light or dark").click(force=True)
    keys.press("Space")
    window.wait_for_text("s: running")
    window.button("Light or dark").click(force=True)
    window.select("pick")
    window.button("Step").click(force=True)
    window.wait_for_text("s: paused")
    keys.press("ArrowDown")
    wait_until(lambda: "Sequence" in window.page.locator(".line.chosen").inner_text())


def test_there_is_no_empty_picture_while_the_page_is_opened(window):
    page = window.page.context.new_page()
    page.add_init_script(
        "window.broken = 0; setInterval(() => { for (const one of document.images)"
        " window.broken += one.offsetParent !== null && !one.naturalWidth; }, 5);"
    )
    page.goto(window.page.url)
    page.locator(".line .name").first.wait_for()
    page.wait_for_timeout(500)
    assert page.evaluate("() => window.broken") == 0
    page.close()


ROOM = """
    () => [...document.querySelectorAll(".line:not([hidden]) .message")]
        .filter((one) => one.textContent && one.offsetParent)
        .map((one) => {
            const name = one.parentElement.querySelector(".name").getBoundingClientRect();
            const room = one.clientWidth - parseFloat(getComputedStyle(one).paddingLeft);
            return [one.textContent, room, one.scrollWidth <= one.clientWidth,
                one.parentElement.className, one.getBoundingClientRect().top - name.top];
        })
"""
"""Gives text, room [pixels], whether it is whole, classes of the row, and distance to the name."""


def test_a_message_has_room_for_20_letters_or_is_below_its_name(window):
    def rows() -> list[tuple[str, float, bool, bool, bool]]:
        window.wait_for_tree("IsHolding +the gripper holds nothing")
        return [
            (text, room, is_whole, below > 10, "two" in classes.split())
            for text, room, is_whole, classes, below in window.page.evaluate(ROOM)
        ]

    try:
        for width, height in ((1400, 900), (1280, 720), (700, 900)):
            window.page.set_viewport_size({"width": width, "height": height})
            if width == 700:
                window.open_tab("Tree")
            wait_until(lambda some=width > 700: any(two for *_, two in rows()) == some)
            for text, room, is_whole, is_below, two in rows():
                assert is_whole or room >= 120, text
                assert is_below == two, text
            window.keep(f"messages_{width}")
    finally:
        window.page.set_viewport_size(SIZE)
        window.open_tab("Log")


def test_sky_and_ground_of_the_scene_are_dark_where_the_page_is(opengl, paused):
    brightness = {}
    for theme in ("light", "dark"):
        if paused.page.evaluate("() => document.documentElement.dataset.theme") != theme:
            paused.press("Light or dark")
        pixels = paused.scene(f"scene_{theme}")
        height, width = pixels.shape[:2]
        sky = pixels[: height // 20, : width // 4]
        # Where the table is depends on the pose of the arm at which the page was opened.
        ground = paused.scene_without("/table")[height // 2 :, : width // 20]
        brightness[theme] = np.median(sky), np.median(ground)
    assert min(brightness["light"]) > 150 and max(brightness["dark"]) < 110, brightness
    paused.press("Light or dark")


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
    window.wait_for_text("IsHolding: no, the gripper holds nothing")
    window.page.get_by_label("condition").uncheck()
    window.open_tab("Blackboard")
    window.wait_for_text("cube\\s+auto")
    window.open_tab("Plots")
    window.page.locator("canvas.plot").first.wait_for()
    for number, quantity in enumerate(("Grip force", "Height of objects"), 2):
        window.choose("Quantity", quantity)
        wait_until(lambda count=number: window.page.locator("canvas.plot").count() == count)
    window.page.wait_for_timeout(500)
    for plot in window.page.locator("canvas.plot").all():
        drawn = plot.evaluate(
            "canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data"
            ".filter((value, index) => index % 4 == 3 && value > 0).length"
        )
        assert drawn > 100
    window.keep("plots")
    line = window.page.get_by_role("slider", name="Timeline")
    window.page.locator("canvas.plot").first.click(position={"x": 150, "y": 60})
    window.button("Back to now").wait_for()
    assert float(line.get_attribute("aria-valuenow")) < window.time()
    window.press("Back to now")
    window.press("Remove Grip force")
    wait_until(lambda: window.page.locator("canvas.plot").count() == 2)
    window.open_tab("Log")


def test_stop_ends_the_run_with_the_exit_code_of_an_interrupted_one(program, window):
    window.press("Stop")
    window.wait_for_text("s: stopped")
    program.wait_for("stays up")
    assert program.interrupt() == 130
    assert not program.errors.read_text()
