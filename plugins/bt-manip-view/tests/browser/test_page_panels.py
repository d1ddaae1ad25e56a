"""The page of ``bt-manip run --view --watch``: breakpoints, ports, planned path, pull and edits."""

import os
from pathlib import Path

import pytest

from .conftest import Program, wait_until

TREE = """<root BTCPP_format="4"><BehaviorTree ID="Main" _results="count"><Sequence name="task">
  <Sleep name="begin" msec="50" _onSuccess="count := 3" _break="true"/>
  <SpawnObject name="spawn" region="0.3;0.3;-0.2;-0.2" object="{cube}"/>
  <Repeat num_cycles="-1"><Sequence name="there and back">
    <MoveToConfiguration name="away" configuration="0;0.3;0;-1.8;0;2.1;0.8" speed="0.5"/>
    <MoveHome name="home" speed="0.5"/>
  </Sequence></Repeat>
</Sequence></BehaviorTree></root>
"""


PATH_IS_DRAWN = "() => Boolean(__viserMutable.nodeRefFromName['/planned path of panda'])"


@pytest.fixture(scope="module")
def tree(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("tree") / "task.xml"
    path.write_text(TREE)
    return path


@pytest.fixture(scope="module")
def program(tree, start) -> Program:
    options = ("--view", "--watch", "--real-time", "1", "--view-breakpoints", "spawn")
    return start("run", tree, *options)


def test_breakpoints_of_the_file_and_of_the_option_are_set_on_each_page(
    program, shared_window, open_window
):
    window = shared_window
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
        if window.evaluate(PATH_IS_DRAWN):
            return True
        window.press("Continue")  # between two motions there is no path
        return False

    wait_until(paused_in_a_motion)
    shown = window.scene("planned_path")
    changed = abs(shown - window.scene_without("/planned path of panda")).max(axis=2) > 20
    assert changed.sum() > 100


def test_a_clicked_object_is_pulled_by_its_handle_and_falls_when_it_is_let_go(window):
    window.page.mouse.click(*window.pixel("/cube/cube:cube"))
    wait_until(lambda: window.evaluate("() => !!__viserMutable.nodeRefFromName['/handle']"))
    window.open_tab("Pull")
    assert window.page.get_by_label("Object", exact=True).input_value() == "cube"

    def height() -> float:
        return window.pixel("/cube/cube:cube")[1]

    before = height()
    higher = before - 30  # pixels, downwards
    window.pull("/handle", (0.0, 0.0, 0.11), (0.0, 0.0, 0.35), lambda: height() < higher)
    window.page.mouse.up()
    wait_until(lambda: abs(height() - before) < 5)
    window.open_tab("Log")
    window.wait_for_text("cube is let go")


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
