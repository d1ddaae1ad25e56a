"""The next run is chosen on the page."""

from types import SimpleNamespace

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
    return page._panels[-1]


def choose(panel, i, value):
    """Choose as on an open page: 0 is the tree, 1 the scene, 2 the robot."""
    panel._inputs[i].value = value
    panel._chosen(SimpleNamespace(client_id=1, target=panel._inputs[i]))


def press(panel, button):
    panel._pressed(SimpleNamespace(target=SimpleNamespace(value=button)))


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
    run = make_run(Sleep("rest", msec=20))
    page.begin_idle(run.station)
    shown = [panel._folder.visible, page.controls._stop.visible]
    run.execute([page])
    shown += [panel._folder.visible, page.controls._stop.visible]
    page.begin_idle(run.station)
    shown += [panel._folder.visible, page.controls._stop.visible]
    assert shown == [True, False, False, True, True, False]
