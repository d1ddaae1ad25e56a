"""The next run is chosen on the page."""

import pytest

from bt_manip.bt import Sleep
from bt_manip_view import Page
from bt_manip_view.page.session_panel import RunChoice, SessionPanel

NAMES = {"tree": ("pick", "stack"), "scene": ("table", "tray"), "robot": ("panda", "ur5e")}


@pytest.fixture
def page(make_run):
    def make(page):
        page.session = SessionPanel(
            page, NAMES, RunChoice("pick", "table", "panda", 0, 1),
            {"pick": "table", "stack": "tray"}.get, {"table": 0, "tray": 5}.get,
        )  # fmt: skip
        return page.session

    page = Page({"session": make}, port=0, speed=None)
    page.begin_idle(make_run(Sleep("rest", msec=20)).station)
    yield page
    page.close()


@pytest.fixture
def panel(page):
    return page.session


def test_a_request_is_taken_once(panel, client):
    assert panel.take() is None
    client.press("▶ Run")
    assert panel.take() == ("run", RunChoice("pick", "table", "panda", 0, 1))
    assert panel.take() is None


def test_a_tree_brings_its_scene_and_a_scene_its_seed(panel, client):
    client.set("dropdown", "Tree", "stack")
    assert panel.take() == ("show", RunChoice("stack", "tray", "panda", 5, 1))
    client.set("dropdown", "Scene", "table")
    assert panel.take() == ("show", RunChoice("stack", "table", "panda", 0, 1))


def test_the_chosen_robot_seed_and_cycles_are_kept_for_the_same_scene(panel, client):
    client.set("number", "Seed", 7)
    client.set("number", "Cycles", 3)
    client.set("dropdown", "Robot", "ur5e")
    client.press("Reset")
    assert panel.take() == ("reset", RunChoice("pick", "table", "ur5e", 7, 3))


def test_messages_are_escaped(panel, client):
    panel.tell("no <tree>", error=True)
    assert "no &lt;tree&gt;" in client.text()
    panel.tell("")
    assert not client.text()


def test_the_choice_is_hidden_while_a_tree_runs(page, client, make_run):
    def shown():
        folder = client.see().elements[client.find("dropdown", "Tree")["parent"]]
        return [one["visible"] for one in (
            folder, client.find("button", "▶ Run"), client.find("button", "Stop"),
        )]  # fmt: skip

    run = make_run(Sleep("rest", msec=20))
    page.begin_idle(run.station)
    assert shown() == [True, True, False]
    run.execute([page])
    assert shown() == [False, False, True]
    page.begin_idle(run.station)
    assert shown() == [True, True, False]


def test_the_result_comes_to_the_front_until_the_next_run(panel, client, make_run):
    panel.show_result("FAILURE", "cycle 1: never")
    tab = client.see().find("tab", "Result")
    assert tab["visible"] and tab["front"] == 1
    panel.start(make_run(Sleep("rest", msec=20)))
    assert not client.see().find("tab", "Result")["visible"]
