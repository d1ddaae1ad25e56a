"""The next run is chosen on the page."""

import json

import pytest

from bt_manip.bt import Sleep
from bt_manip.viewer import Page
from bt_manip.viewer.page import RunChoice, SessionPanel

NAMES = {"tree": ("pick", "stack"), "scene": ("table", "tray"), "robot": ("panda", "ur5e")}


@pytest.fixture
def page():
    def make(page):
        return SessionPanel(
            page, NAMES, RunChoice("pick", "table", "panda", 0, 1),
            {"pick": "table", "stack": "tray"}.get, {"table": 0, "tray": 5}.get,
        )  # fmt: skip

    page = Page({"session": make}, port=0, speed=None)
    yield page
    page.close()


@pytest.fixture
def panel(page):
    (panel,) = (panel for panel in page._panels if isinstance(panel, SessionPanel))
    return panel


def choose(panel, i, value):
    """Choose as on an open page: 0 is the tree, 1 the scene, 2 the robot."""
    use(panel, panel._inputs[i], "value", value)


def press(panel, button):
    use(panel, {"Run": panel._run, "Reset": panel._reset}[button], "click", None)


def use(panel, element, event, value):
    element.visible = True
    data = json.dumps({"id": element.uid, "event": event, "value": value})
    assert element._gui.receive(data)


def test_nothing_is_asked_for_at_first(panel):
    assert panel.take() is None


def test_a_request_is_taken_once(panel):
    press(panel, "Run")
    assert panel.take() == ("run", RunChoice("pick", "table", "panda", 0, 1))
    assert panel.take() is None


def test_a_tree_brings_its_scene_and_the_seed_of_the_scene(panel):
    choose(panel, 0, "stack")
    assert panel.take() == ("show", RunChoice("stack", "tray", "panda", 5, 1))


def test_a_scene_brings_its_seed_and_keeps_the_tree(panel):
    choose(panel, 1, "tray")
    assert panel.take() == ("show", RunChoice("pick", "tray", "panda", 5, 1))


def test_the_chosen_robot_seed_and_cycles_are_kept_for_the_same_scene(panel):
    panel._seed.value, panel._cycles.value = 7, 3
    choose(panel, 2, "ur5e")
    press(panel, "Reset")
    assert panel.take() == ("reset", RunChoice("pick", "table", "ur5e", 7, 3))


def test_messages_are_escaped(panel):
    panel.tell("no <tree>", error=True)
    assert "no &lt;tree&gt;" in panel._message.content
    panel.tell("")
    assert not panel._message.content


def test_the_choice_is_hidden_while_a_tree_runs(page, panel, make_run):
    def shown():
        return [panel._folder.visible, panel._run.visible, page.controls._stop.visible]

    run = make_run(Sleep("rest", msec=20))
    page.begin_idle(run.station)
    assert shown() == [True, True, False]
    run.execute([page])
    assert shown() == [False, False, True]
    page.begin_idle(run.station)
    assert shown() == [True, True, False]


def test_the_result_comes_to_the_front_until_the_next_run(panel, make_run):
    panel.show_result("FAILURE", "cycle 1: never")
    assert panel._tab.visible and panel._tab.front == 1
    panel.start(make_run(Sleep("rest", msec=20)))
    assert not panel._tab.visible
