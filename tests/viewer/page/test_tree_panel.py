"""The inputs of the tree panel: choosing a node, breakpoints, folding, errors of an edit."""

import pytest

from bt_manip import build_station
from bt_manip.behaviours import RemoveObject, SpawnObject
from bt_manip.bt import AlwaysFailure, Fallback, Sequence, Sleep
from bt_manip.runner import RunObserver


@pytest.fixture
def panel(page):
    (panel,) = [panel for panel in page._panels if type(panel).__name__ == "TreePanel"]
    return panel


def tree():
    return Sequence(
        "root", Fallback("try", AlwaysFailure("never"), Sleep("rest", msec=20)),
        SpawnObject("spawn", object="{cube}"), RemoveObject("remove", object="{cube}"),
    )  # fmt: skip


def press(panel, *buttons):
    panel._buttons.extend(buttons)
    panel.draw()


def test_a_chosen_node_shows_its_ports_and_values(make_run, page, panel):
    make_run(tree()).execute([page])
    assert panel._choice.options == ("none", "root", "try", "never", "rest", "spawn", "remove")
    panel._choice.value = "spawn"
    panel.draw()
    html = panel._chosen_html.content
    assert "SpawnObject, success" in html and "{cube}" in html and "cube = cube" in html
    assert panel._html.content.count("background:") == 1


def test_nodes_are_chosen_by_buttons(make_run, page, panel):
    make_run(tree()).execute([page])
    press(panel, "Parent", "Fold", "Breakpoint", "Running")  # nothing is chosen, nothing runs
    assert panel._choice.value == "none"
    press(panel, "Failed")
    assert panel._choice.value == "never" and "always fails" in panel._chosen_html.content
    press(panel, "Parent", "Fold")
    assert panel._choice.value == "try"
    assert ">never<" not in panel._html.content
    press(panel, "Parent", "Parent")
    assert panel._choice.value == "root"


def test_several_breakpoints_are_set_and_removed_in_a_list(make_run, page, panel):
    make_run(tree()).execute([page])
    for path in ("spawn", "rest"):
        panel._choice.value = path
        press(panel, "Breakpoint")
    assert page.controls.breakpoints == {"spawn", "rest"}
    buttons = panel._breakpoints
    assert [button.label for button in buttons.values()] == ["✕ spawn", "✕ rest"]
    assert panel._html.content.count("●") == 2
    for _ in range(2):  # a double click
        panel._unset.append("spawn")  # as its button does
    panel.draw()
    assert list(buttons) == ["rest"]
    press(panel, "Breakpoint")
    assert page.controls.breakpoints == frozenset()
    assert not buttons and not panel._folder.visible


def test_errors_of_an_edited_tree_are_shown_until_they_are_gone(make_run, page, panel):
    seen = []

    class Editor(RunObserver):
        def run_started(self, run):
            self.emit = run.events.emit

        def after_tick(self):
            wrong = len(seen) < 2
            problem = "task.xml:3:7: error: unknown node '<Slep>'"
            self.emit("edit", {"problems": [problem] if wrong else []})
            panel.draw()
            seen.append(panel._problem_html.content)

    make_run(Sleep("rest", msec=30)).execute([page, Editor()])
    assert "task.xml:3:7: error: unknown node &#x27;&lt;Slep&gt;&#x27;" in seen[1]
    assert seen[-1] == ""


def test_statuses_and_values_are_kept_until_there_is_a_new_cell(make_run, page, panel, parts):
    run = make_run(tree())
    run.execute([page])
    page.begin_idle(run.station)
    assert "✗" in panel._html.content and panel._values
    page.begin_idle(build_station(parts))
    assert ">never<" in panel._html.content and not panel._values
    assert "✗" not in panel._html.content and "✓" not in panel._html.content
