"""What a person sees and does on the page of a cell (``bt-manip view``), and of a run in it."""

import time

import mujoco
import numpy as np
import pytest

from bt_manip.runner import RunRequest, find_tree, prepare
from bt_manip.viewer import render

from .conftest import CORNERS, SIZE, Program, Window, empty, wait_until

SIZES = [(1400, 900), (1280, 720), (700, 900)]

SHOWN = {
    "pick_place": ("/panda", "/basket", "/cube"),
    "two_arms": ("/left", "/right", "/left_basket", "/right_basket"),
}
"""Starts of the names of nodes that have to be seen, by tree."""

OTHERS = ("/WorldAxes", "/world", "/table", "/jog", "/planned path")
"""Starts of the names of nodes that need not be seen."""

NAMES = """
    () => Object.entries(__viserMutable.nodeRefFromName).filter(([, node]) => node).map(([n]) => n)
"""
"""Gives the names of the nodes that are there: the names of removed ones are kept."""

CAMERA = """
    () => {
        const { nodeRefFromName, camera } = __viserMutable, world = nodeRefFromName[''];
        camera.updateMatrixWorld();
        world.updateMatrixWorld();
        return world.matrixWorld.clone().invert().multiply(camera.matrixWorld).toArray();
    }
"""
"""Gives the pose of the camera in the world, a 4x4 matrix by columns."""

TOOL = 0.1034
"""Distance of the Panda's tool from its hand [m]."""

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
    return start("view", "pick_place", "--cycles", "0", "--seed", "3")


@pytest.fixture
def paused(window) -> Window:
    window.press("Pause")
    window.wait_for_text("s: paused")
    return window


def test_a_joint_slider_moves_the_arm_which_is_saved_by_name(shared_window):
    window = shared_window
    window.open_tab("Jog")
    before = window.pixel("/panda/panda:hand")
    joint1 = window.page.get_by_role("spinbutton", name="joint1 [rad] value")
    joint1.fill("0.5")
    joint1.press("Enter")

    def moved() -> bool:
        return abs(window.pixel("/panda/panda:hand")[0] - before[0]) > 20

    wait_until(moved)
    window.page.get_by_label("Save as").fill("beside")
    window.press("Save configuration")
    window.wait_for_text(r"beside.*configurations\.toml")


def test_the_tool_follows_the_handle_that_the_mouse_drags_by_an_arrow(shared_window):
    window = shared_window
    window.open_tab("Jog")
    hand, handle = "/panda/panda:hand", "/jog/panda"

    def settled() -> bool:
        """Return whether the handle is at the tool, where it is while the arm rests."""
        return abs(np.linalg.norm(window.position(hand) - window.position(handle)) - TOOL) < 1e-3

    wait_until(settled)
    before = window.position(hand)
    arrow = (0.0, 0.0, -0.12)  # the tool points down, and so does the arrow of its z axis
    expected = before + (0.0, 0.0, 0.1)

    def is_at(position: np.ndarray) -> bool:
        return bool(np.abs(window.position(hand) - position).max() < 0.005)

    window.pull(handle, arrow, (0.0, 0.0, arrow[2] + 0.1), lambda: not is_at(before))
    window.page.mouse.up()
    wait_until(lambda: is_at(expected))
    wait_until(settled)
    out_of_reach = (0.0, 0.0, arrow[2] + 2.0)
    window.pull(handle, arrow, out_of_reach, lambda: "the pose is unreachable" in window.text())
    window.page.mouse.up()
    wait_until(settled)
    assert is_at(expected)


def test_a_tree_runs_is_stopped_and_the_cell_is_reset(shared_window):
    window = shared_window
    assert "SpawnObject" in window.tree() and "s: ready" in window.text()
    window.set_breakpoint("SpawnObject")
    window.press("▶ Run")
    window.wait_for_text("s: paused at .*SpawnObject")
    window.set_breakpoint("SpawnObject")
    window.press("Continue")
    window.wait_for_tree("▶ (Hover|Reach|Lift|Drop)")
    window.press("Stop")
    window.wait_for_text("INTERRUPTED")
    window.wait_for_text(r"recorded: bt-manip run pick_place .*--record run\.mcap")
    window.button("Reset").wait_for()
    window.press("Reset")
    wait_until(lambda: window.time() < 1.0)
    window.press("▶ Run")  # again
    window.wait_for_text("cycle 1, .*running")


def framed(window: Window, tree: str) -> np.ndarray:
    """Check what is inside the picture at each size of the window; return the last, and pause."""
    names: list[str] = []

    def there() -> bool:
        found = window.evaluate(NAMES)
        names[:] = [name for name in found if name.count("/") == 1]
        names[:] = [name for name in names if not name.startswith(OTHERS)]
        return all(any(name.startswith(one) for name in names) for one in SHOWN[tree])

    def paused() -> bool:
        wait_until(there, lambda: f"{names}")
        window.press("Pause")
        window.wait_for_text("s: paused")
        if not there():  # an object has gone meanwhile
            window.press("Continue")
        return window.button("Continue").count() > 0 and there()

    wait_until(paused)
    seen: list[float] = []

    def inside() -> bool:
        corners = np.abs(np.array(window.evaluate(CORNERS, names)))
        seen[:] = [float(corners.max()), len(corners)]
        return 0.6 < seen[0] < 1.0 and seen[1] > 100

    for width, height in reversed(SIZES):
        window.page.set_viewport_size({"width": width, "height": height})
        wait_until(inside, lambda: f"{window.page.viewport_size}: {seen}")
    pixels = window.scene(f"{tree}_{width}x{height}")
    assert min(len(np.unique(part)) for part in np.array_split(pixels, 3, axis=1)) > 100
    return pixels


def test_what_the_task_is_about_is_drawn_as_a_camera_of_mujoco_there_sees_it(opengl, window, parts):
    shown = framed(window, "pick_place")
    share = (abs(shown - window.scene_without("/panda")).max(axis=2) > 20).mean()
    source = find_tree("pick_place", {"pick_place": parts.trees.get("pick_place")})
    run = prepare(RunRequest(source, seed=3, cycles=0), parts)
    cell, due = run.station.cell, window.time()
    run.execute(stop=lambda: cell.time >= due - 1e-3)
    pose = np.array(window.evaluate(CAMERA)).reshape(4, 4).T
    camera = cell.model.camera("overview")
    camera.pos[:] = pose[:3, 3]
    mujoco.mju_mat2Quat(camera.quat, np.ascontiguousarray(pose[:3, :3]).ravel())
    camera.fovy[:] = window.evaluate("() => __viserMutable.camera.fov")
    height, width = shown.shape[:2]
    expected = render(cell, width=width, height=height).astype(int)
    cell.model.geom_rgba[_robot(cell.model)] = 0.0
    cell.model.geom_matid[_robot(cell.model)] = -1
    without = render(cell, width=width, height=height).astype(int)
    window.page.set_viewport_size(SIZE)
    drawn = (abs(expected - without).max(axis=2) > 20).mean()
    assert share == pytest.approx(drawn, rel=0.5)  # shadows differ


def _robot(model):
    names = [model.body(body).name for body in model.geom_bodyid]
    return [geom for geom, name in enumerate(names) if name.startswith("panda/")]


def test_the_picture_of_a_chosen_camera_is_over_the_scene(opengl, window):
    picture = window.page.locator("img.picture")
    assert not picture.is_visible()
    window.choose("Camera", "panda/wrist")
    wait_until(lambda: picture.is_visible() and picture.evaluate("one => one.naturalWidth") == 320)
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
    page.route("**/scene*", empty)
    page.add_init_script(
        "window.broken = 0; setInterval(() => { for (const one of document.images)"
        " window.broken += one.offsetParent !== null && !one.naturalWidth; }, 5);"
    )
    page.goto(window.page.url)
    page.locator(".line .name").first.wait_for()
    page.wait_for_timeout(200)
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
        for width, height in ((1280, 720), (700, 900)):
            window.page.set_viewport_size({"width": width, "height": height})
            if width == 700:
                window.open_tab("Tree")
            wait_until(lambda some=width > 700: any(two for *_, two in rows()) == some)
            for text, room, is_whole, is_below, two in rows():
                assert is_whole or room >= 120, text
                assert is_below == two, text
    finally:
        window.page.set_viewport_size(SIZE)
        window.open_tab("Log")


def test_sky_and_ground_of_the_scene_are_dark_where_the_page_is(opengl, paused):
    brightness = {}
    for theme in ("light", "dark"):
        if paused.page.evaluate("() => document.documentElement.dataset.theme") != theme:
            paused.press("Light or dark")
        # Where the table is depends on the pose of the arm at which the page was opened.
        pixels = paused.scene_without("/table")
        height, width = pixels.shape[:2]
        sky, ground = pixels[: height // 20, : width // 4], pixels[height // 2 :, : width // 20]
        brightness[theme] = np.median(sky), np.median(ground)
    assert min(brightness["light"]) > 150 and max(brightness["dark"]) < 110, brightness
    paused.press("Light or dark")


def test_the_speed_can_be_changed(window):
    def has_slowed_down() -> bool:
        start, before = time.monotonic(), window.time()
        time.sleep(1.0)
        after, elapsed = window.time(), time.monotonic() - start
        return 0.0 < after - before < 0.1 * elapsed + 0.1

    window.choose("Speed", "1/10")
    wait_until(has_slowed_down)  # the page may show it later
    slow = window.time()
    window.choose("Speed", "1")
    wait_until(lambda: window.time() > slow + 1.0)


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
    assert program.interrupt() == 130
    assert not program.errors.read_text()


@pytest.mark.soak
def test_what_a_task_of_two_robots_is_about_is_inside_the_picture(start, open_window):
    program = start("run", "two_arms", "--view", "--real-time", "1", "--cycles", "0", "--seed", "3")
    window = open_window(program.url)
    window.wait_for_scene()
    window.wait_for_text("cycle 1, ")
    framed(window, "two_arms")
