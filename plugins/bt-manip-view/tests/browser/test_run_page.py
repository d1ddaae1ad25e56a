"""What a person sees and does on the page of a cell (``bt-manip view``), and of runs in it."""

import os
import re
import time
from pathlib import Path

import mujoco
import numpy as np
import pytest

from bt_manip.runner import RunRequest, find_tree, prepare
from bt_manip.viewer import render

from ..conftest import Program
from .conftest import CORNERS, SIZE, Window, empty, wait_until

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

DRAWN = """
    canvas => canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data
        .filter((value, index) => index % 4 == 3 && value > 0).length
"""
"""Gives the number of pixels of a plot that are not empty."""

RED = """
    () => {
        const one = document.body.appendChild(document.createElement("i"));
        one.style.color = "var(--red)";
        return getComputedStyle(one).color;
    }
"""
"""Gives the colour of failures."""

TREE = """<root BTCPP_format="4"><BehaviorTree ID="Main" _results="count"><Sequence name="task">
  <Sleep name="begin" msec="50" _onSuccess="count := 3" _break="true"/>
  <SpawnObject name="spawn" region="0.3;0.3;-0.2;-0.2" object="{cube}"/>
  <Repeat num_cycles="-1"><Sequence name="there and back">
    <MoveToConfiguration name="away" configuration="0;0.3;0;-1.8;0;2.1;0.8" speed="0.5"/>
    <MoveHome name="home" speed="0.5"/>
  </Sequence></Repeat>
</Sequence></BehaviorTree></root>
"""


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("tree") / "task.xml"
    path.write_text(TREE)
    return path


@pytest.fixture(scope="module")
def program(start, tree) -> Program:
    options = ("--cycles", "0", "--seed", "3", "--watch", "--view-breakpoints", "spawn")
    return start("view", tree, *options)


@pytest.fixture
def paused(shared_window) -> Window:
    """Give the page of the run that is paused at the start of Lift."""
    assert shared_window.button("Continue").count()
    return shared_window


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


def test_a_tree_is_chosen_and_runs_in_a_cell_that_is_reset(shared_window):
    window = shared_window
    window.choose("Tree", "pick_place")
    window.wait_for_tree("SpawnObject")
    window.press("Reset")
    wait_until(lambda: "s: ready" in window.text() and window.time() < 1.0)
    window.set_breakpoint("Lift")
    window.choose("Speed", "as fast as possible")
    window.press("▶ Run")
    window.wait_for_text("cycle 1, .*s: paused at .*/Lift")
    window.set_breakpoint("Lift")
    window.choose("Speed", "1")


def check_framing(window: Window, tree: str) -> None:
    """Check that robots and objects are inside the picture at each size of the window."""
    names: list[str] = []

    def there() -> bool:
        found = window.evaluate(NAMES)
        names[:] = [name for name in found if name.count("/") == 1]
        names[:] = [name for name in names if not name.startswith(OTHERS)]
        return all(any(name.startswith(one) for name in names) for one in SHOWN[tree])

    wait_until(there, lambda: f"{names}")
    seen: list[float] = []

    def inside() -> bool:
        seen[:] = window.evaluate(CORNERS, names)
        return 0.6 < seen[0] < 1.0 and seen[1] > 100

    for width, height in reversed(SIZES):
        window.page.set_viewport_size({"width": width, "height": height})
        wait_until(inside, lambda: f"{window.page.viewport_size}: {seen}")
    pixels = window.scene(f"{tree}_{width}x{height}")
    assert min(len(np.unique(part)) for part in np.array_split(pixels, 3, axis=1)) > 100


def test_what_the_task_is_about_is_drawn_as_a_camera_of_mujoco_there_sees_it(opengl, paused, parts):
    window = paused
    check_framing(window, "pick_place")
    pose = None
    while pose != (now := window.evaluate(CAMERA)):  # it has moved meanwhile
        pose, shown = now, window.scene()
        share = (abs(shown - window.scene_without("/panda")).max(axis=2) > 20).mean()
    source = find_tree("pick_place", {"pick_place": parts.trees.get("pick_place")})
    run = prepare(RunRequest(source, seed=3, cycles=0), parts)
    cell, due = run.station.cell, window.time()
    run.execute(stop=lambda: cell.time >= due - 1e-3)
    pose = np.reshape(pose, (4, 4)).T
    camera = cell.model.camera("overview")
    camera.pos[:] = pose[:3, 3]
    mujoco.mju_mat2Quat(camera.quat, np.ascontiguousarray(pose[:3, :3]).ravel())
    camera.fovy[:] = window.evaluate("() => __viserMutable.camera.fov")
    height, width = (length // 2 for length in shown.shape[:2])
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


def test_the_picture_of_a_chosen_camera_is_over_the_scene(opengl, paused):
    picture = paused.page.locator("img.picture")
    assert not picture.is_visible()
    before = None
    for camera in ("panda/wrist", "overview"):
        paused.choose("Camera", camera)
        wait_until(lambda old=before: picture.is_visible() and picture.get_attribute("src") != old)
        assert picture.evaluate("async one => (await one.decode(), one.naturalWidth)") == 320
        before = picture.get_attribute("src")
    paused.choose("Camera", "none")
    wait_until(lambda: not picture.is_visible())


def test_the_tree_has_signs_messages_and_times_and_a_no_is_not_red(paused):
    paused.wait_for_tree("✓ SpawnObject +'cube' at")
    paused.wait_for_tree("no IsHolding +the gripper holds nothing, not 'cube'")
    paused.wait_for_tree(r"✓ Reach .*\d\.\d\d s$")
    paused.wait_for_tree("▶ Lift")
    red = paused.page.evaluate(RED)
    assert red != paused.node("IsHolding").locator(".name").evaluate(COLOUR)


def test_there_is_no_empty_picture_while_the_page_is_opened(paused):
    page = paused.page.context.new_page()
    page.route("**/scene*", empty)
    page.add_init_script(
        "window.broken = 0; setInterval(() => { for (const one of document.images)"
        " window.broken += one.offsetParent !== null && !one.naturalWidth; }, 5);"
    )
    page.goto(paused.page.url)
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


def test_a_message_has_room_for_20_letters_or_is_below_its_name(paused):
    def rows() -> list[tuple[str, float, bool, bool, bool]]:
        paused.wait_for_tree("IsHolding +the gripper holds nothing")
        return [
            (text, room, is_whole, below > 10, "two" in classes.split())
            for text, room, is_whole, classes, below in paused.page.evaluate(ROOM)
        ]

    try:
        for width, height in ((1280, 720), (700, 900)):
            paused.page.set_viewport_size({"width": width, "height": height})
            if width == 700:
                paused.open_tab("Tree")
            wait_until(lambda some=width > 700: any(two for *_, two in rows()) == some)
            for text, room, is_whole, is_below, two in rows():
                assert is_whole or room >= 120, text
                assert is_below == two, text
    finally:
        paused.page.set_viewport_size(SIZE)
        paused.open_tab("Log")


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


def test_a_click_selects_an_arrow_folds_and_a_double_click_shows_a_sub_tree_alone(paused):
    paused.select("Grasp")
    paused.wait_for_text("attempt/pick/Grasp")
    paused.wait_for_text("Action Grasp, ")
    paused.node("pick").locator(".fold").click(force=True)
    wait_until(lambda: "Grasp" not in paused.tree())
    paused.node("pick").locator(".fold").click(force=True)
    wait_until(lambda: "Grasp" in paused.tree())
    paused.node("pick").locator(".name").dblclick(force=True)
    wait_until(lambda: paused.tree().split()[1] == "pick")
    paused.press("⬑ Whole tree")
    wait_until(lambda: "SpawnObject" in paused.tree())


def test_the_keys_are_those_of_a_file_tree(paused):
    keys = paused.page.keyboard
    paused.select("pick")
    for key, selected in {
        "ArrowLeft": "pick",
        "ArrowRight": "pick",
        "ArrowDown": "Sequence",
    }.items():
        keys.press(key)
        wait_until(lambda name=selected: name in paused.page.locator(".line.chosen").inner_text())
    keys.press("b")
    paused.page.locator(".line.chosen .margin.set").wait_for()
    keys.press("b")
    wait_until(lambda: not paused.page.locator(".margin.set").count())
    keys.press("/")
    keys.type("drop")
    wait_until(lambda: "Lift" not in paused.tree() and "Drop" in paused.tree())
    keys.press("Escape")
    wait_until(lambda: "Lift" in paused.tree())


def test_log_blackboard_and_plot_are_in_tabs(paused):
    paused.open_tab("Log")
    paused.wait_for_text("cube added")
    paused.wait_for_text(r"Grasp: fingers press with")
    assert "IsHolding: " not in paused.text()
    paused.page.get_by_label("condition").check()
    paused.wait_for_text("IsHolding: no, the gripper holds nothing")
    paused.page.get_by_label("condition").uncheck()
    paused.open_tab("Blackboard")
    paused.wait_for_text("cube\\s+auto")
    paused.open_tab("Plots")
    paused.page.locator("canvas.plot").first.wait_for()
    for number, quantity in enumerate(("Grip force", "Height of objects"), 2):
        paused.choose("Quantity", quantity)
        wait_until(lambda count=number: paused.page.locator("canvas.plot").count() == count)
    for plot in paused.page.locator("canvas.plot").all():
        wait_until(lambda one=plot: one.evaluate(DRAWN) > 100)
    line = paused.page.get_by_role("slider", name="Timeline")
    paused.page.locator("canvas.plot").first.click(position={"x": 80, "y": 60})
    paused.button("Back to now").wait_for()
    assert float(line.get_attribute("aria-valuenow")) < paused.time()
    paused.press("Back to now")
    paused.press("Remove Grip force")
    wait_until(lambda: paused.page.locator("canvas.plot").count() == 2)
    paused.open_tab("Log")


def test_the_speed_can_be_changed(window):
    def has_slowed_down() -> bool:
        start, before = time.monotonic(), window.time()
        time.sleep(0.5)
        after, elapsed = window.time(), time.monotonic() - start
        return 0.0 < after - before < 0.1 * elapsed + 0.1

    window.choose("Speed", "1/10")
    wait_until(has_slowed_down)  # the page may show it later
    slow = window.time()
    window.choose("Speed", "1")
    wait_until(lambda: window.time() > slow + 0.3)


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


def test_a_run_is_stopped_and_another_pauses_at_breakpoints_of_file_and_option_on_each_page(
    program, window, tree, open_window
):
    window.press("Stop")
    window.wait_for_text("s: stopped")
    window.wait_for_text("INTERRUPTED")
    window.wait_for_text(r"To keep it: bt-manip run pick_place .*--record run\.mcap")
    window.choose("Tree", str(tree))
    window.wait_for_tree("spawn")
    window.press("Reset")
    wait_until(lambda: window.time() < 1.0)
    window.press("▶ Run")
    window.wait_for_text("s: paused at begin")
    window.press("Continue")
    window.wait_for_text("s: paused at spawn")
    again = open_window(program.url, scene=False)
    again.wait_for_tree("✓ begin")
    marked = again.page.locator(".line:not([hidden])", has=again.page.locator(".margin.set"))
    wait_until(lambda: marked.locator(".name").all_inner_texts() == ["begin", "spawn"])
    again.page.context.close()
    window.press("Continue")
    window.wait_for_text("s: running")


def test_results_and_ports_of_a_selected_node_have_their_present_values(window):
    window.wait_for_text(r"results\s+count\s+cycle 1\s+3")
    window.select("spawn")
    window.wait_for_text("Action SpawnObject, success")
    window.wait_for_text(r"object\s+output\s+\{cube\}\s+cube = cube")


def test_the_planned_path_is_drawn(opengl, window):
    window.open_tab("Overlays")

    def paused_in_a_motion() -> bool:
        window.wait_for_text(r"panda: 0\.\d+ m in \d+")
        window.press("Pause")
        window.wait_for_text("s: paused")
        if "/planned path of panda" in window.evaluate(NAMES):
            return True
        window.press("Continue")  # between two motions there is no path
        return False

    wait_until(paused_in_a_motion)
    shown = window.scene("planned_path")
    changed = abs(shown - window.scene_without("/planned path of panda")).max(axis=2) > 20
    assert changed.sum() > 100


def test_a_clicked_object_is_pulled_by_its_handle_and_falls_when_it_is_let_go(window):
    # The spawned one: the run before may have left another, even in the gripper.
    nodes = [name for name in window.evaluate(NAMES) if re.match(r"/cube[^/]*/[^/]*:cube$", name)]
    (cube,) = (
        one for one in nodes if np.allclose(window.position(one)[:2], (0.3, -0.2), atol=0.02)
    )

    def clicked() -> bool:  # also where the arm hid it at first
        window.page.mouse.click(*window.pixel(cube))
        window.page.wait_for_timeout(500)
        return bool(window.evaluate("() => !!__viserMutable.nodeRefFromName['/handle']"))

    wait_until(clicked)
    window.open_tab("Pull")
    chosen = window.page.get_by_label("Object", exact=True).input_value()
    assert cube.startswith(f"/{chosen}")

    def height() -> float:  # in the world: the camera turns where the mouse misses the handle
        return window.position(cube)[2]

    before = height()
    window.pull("/handle", (0.0, 0.0, 0.11), (0.0, 0.0, 0.35), lambda: height() > before + 0.03)
    window.page.mouse.up()
    wait_until(lambda: abs(height() - before) < 0.005)
    window.open_tab("Log")
    window.wait_for_text(f"{chosen} is let go")


def write(tree: Path, text: str, time: int) -> None:
    tree.write_text(text)
    os.utime(tree, (time, time))  # another time, however coarse the clock


def test_an_edit_while_the_run_is_paused_is_announced_at_once(window, tree):
    said = "The file was edited: it is read when the run goes on"
    window.press("Pause")
    window.wait_for_text("s: paused")
    assert said not in window.text()
    write(tree, TREE.replace('name="away"', 'name="beside"'), 3)
    window.wait_for_text(said)
    assert "away" in window.tree()
    window.press("Continue")
    window.wait_for_tree("beside")
    wait_until(lambda: said not in window.text())
    for node in ("begin", "spawn"):  # the edited tree begins anew
        window.wait_for_text(f"s: paused at {node}")
        window.press("Continue")
    window.wait_for_text("s: running")


def test_an_edit_with_an_error_is_shown_at_its_line_and_one_with_a_warning_at_its_node(
    window, tree
):
    write(tree, TREE.replace("<MoveHome", "<MoveHme"), 1)
    window.wait_for_text("The edited file has errors, the tree goes on as it was")
    window.wait_for_text(r"task\.xml:6:5: error: .*'MoveHome'")
    write(tree, TREE.replace("<MoveHome", '<MoveHome _skipIf="true"'), 2)
    wait_until(lambda: "The edited file has errors" not in window.text())
    row = window.page.locator(".line", has=window.page.locator(".found:not(:empty)"))
    row.wait_for()
    assert "MoveHome never runs" in row.locator(".found").get_attribute("title")
    row.click()
    window.wait_for_text("⚠ MoveHome never runs: its _skipIf always holds")


def test_stop_ends_the_run_with_the_exit_code_of_an_interrupted_one(program, shared_window):
    window = shared_window
    window.press("Stop")
    window.wait_for_text("s: stopped")
    assert program.interrupt() == 130
    assert not program.errors.read_text()


@pytest.mark.soak
def test_what_a_task_of_two_robots_is_about_is_inside_the_picture(start, open_window):
    program = start("run", "two_arms", "--view", "--seed", "3", "--view-breakpoints", "Lift")
    window = open_window(program.url)
    window.wait_for_scene()
    window.wait_for_text("s: paused at .*Lift")
    check_framing(window, "two_arms")
