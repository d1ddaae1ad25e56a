"""Ports, breakpoints, the planned path, a pull and an edit with an error, as a person sees them."""

import os
from pathlib import Path

import pytest

from .conftest import Program, wait_until

TREE = """<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence name="task">
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
    return start("run", tree, "--view", "--watch", "--real-time", "1")


def test_a_selected_node_shows_its_ports_with_present_values(window):
    window.select("spawn")
    window.wait_for_text("Action SpawnObject, success")
    window.wait_for_text(r"object\s+output\s+\{cube\}\s+cube = cube")
    window.keep("chosen_node")


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
    window.keep("pull")
    window.page.mouse.up()
    wait_until(lambda: abs(height() - before) < 5)
    window.open_tab("Log")
    window.wait_for_text("cube is let go")


def test_an_edit_with_an_error_is_shown_at_its_line_until_it_is_right(window, tree):
    def write(text: str, time: int) -> None:
        tree.write_text(text)
        os.utime(tree, (time, time))  # another time, however coarse the clock

    write(TREE.replace("<MoveHome", "<MoveHme"), 1)
    window.wait_for_text("The edited file has errors, the tree goes on as it was")
    window.wait_for_text(r"task\.xml:5:5: error: .*'MoveHome'")
    window.keep("edit_with_error")
    write(TREE, 2)
    wait_until(lambda: "The edited file has errors" not in window.text())


LARGE_TREE = """<root BTCPP_format="4"><BehaviorTree ID="Main"><Repeat num_cycles="-1">
  <Sequence>{leaves}</Sequence>
</Repeat></BehaviorTree></root>
"""

COUNT_UPDATES = """
    seconds => new Promise((done) => {
        const draw = apply;
        let count = 0;
        window.apply = (changes) => {
            draw(changes);
            count += changes.some(([what, , name]) => what == "merge" && name == "states");
        };
        setTimeout(() => { window.apply = draw; done(count / seconds); }, 1000 * seconds);
    })
"""
"""Gives how often in a second of wall time new states of nodes are drawn."""


@pytest.mark.soak
def test_states_of_500_nodes_are_drawn_several_times_a_second(start, open_window, tmp_path):
    path = tmp_path / "large.xml"
    path.write_text(LARGE_TREE.format(leaves='<Sleep msec="10"/>' * 497))
    program = start("run", path, "--view", "--real-time", "1")
    window = open_window(program.url)
    window.wait_for_scene()
    window.wait_for_tree("▶ Sleep")
    updates = window.page.evaluate(COUNT_UPDATES, 3)
    assert 3.0 < updates < 11.0  # 10 where the computer has time
    assert not window.log
