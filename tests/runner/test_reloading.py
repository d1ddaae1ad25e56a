"""A tree that is edited while it runs."""

import os

import pytest

from bt_manip.bt import BehaviourRegistry
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.runner import Run, RunObserver, RunRequest, TreeSource, known_behaviours, prepare
from bt_manip.runner.reloading import Reloader
from bt_manip.runner.xml_tree import load_document
from tests.support.runs import Listener

from .conftest import still_station

DOCUMENT = """<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main" _results="seen new">
    <Sequence><Script code="seen := {seen}"/>{more}<Sleep msec="{msec}"/></Sequence>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Main"><input_port name="note" default="calm"/>{port}</SubTree>
  </TreeNodesModel>
</root>"""


class Editor(RunObserver):
    def __init__(self, path, at, text):
        self.path, self.at, self.text, self.ticks = path, at, text, 0

    def before_tick(self):
        self.ticks += 1
        if self.ticks == self.at:
            self.path.write_text(self.text)
            os.utime(self.path, ns=(1, 1))  # another time than before, however coarse the clock


def document(seen=1, msec=100, more="", port=""):
    return DOCUMENT.format(seen=seen, msec=msec, more=more, port=port)


def run(tmp_path, edited):
    """Run a tree that sleeps for 0.1 s; its file is edited at the fifth tick, after 40 ms."""
    path = tmp_path / "task.xml"
    path.write_text(document())
    station, told = still_station(), []
    source = TreeSource("task", "xml", path=path)
    tree = load_document(source, Parts(), {"note": "wild"}, lambda: station.cell.time, told.append)
    made = Run(RunRequest(source, settings={"note": "wild"}), tree, station)
    events, reloader = [], Reloader(source, BehaviourRegistry(), told.append)
    made.execute([Listener(events, ("edit",)), Editor(path, 5, edited), reloader])
    made.edits = [event.data["problems"] for event in events]
    return made, told


def test_an_edited_tree_begins_anew_and_keeps_the_blackboard(tmp_path):
    made, told = run(tmp_path, document(seen=2, msec=30, more='<Script code="new := 7"/>'))
    board = made.tree.blackboard
    assert (board["seen"], board["new"], board["note"]) == (2, 7, "wild")
    assert made.station.cell.time == pytest.approx(0.04 + 0.04)
    assert len(told) == 1 and told[0].endswith("was edited; the tree begins anew")
    assert made.edits == [[]]


def test_a_broken_file_changes_nothing_and_its_errors_are_told(tmp_path):
    made, told = run(tmp_path, document(more="<Slep/>"))
    assert made.station.cell.time == pytest.approx(0.11)  # as if nothing had happened
    assert any("task.xml:3:" in line and "did you mean 'Sleep'" in line for line in told)
    assert told[-1].endswith("has errors; the tree goes on as it was")
    (problems,) = made.edits
    assert problems == [line for line in told[:-1] if ": error: " in line]


def test_what_an_edit_can_never_run_is_told_and_it_begins(tmp_path):
    made, told = run(tmp_path, document(msec=30, more='<Sleep _skipIf="true" msec="1"/>'))
    (warning,) = made.tree.warnings
    assert warning.code == "never-runs" and str(warning) in told
    assert told[-1].endswith("was edited; the tree begins anew") and made.edits == [[]]


@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("basket", "was edited; the tree begins anew"),  # removed meanwhile, and there at the start
        (
            "baskt",
            ":3:11: port 'object' of RemoveObject: no object 'baskt'; did you mean 'basket'?",
        ),
    ],
)
def test_an_edit_names_the_objects_of_the_start(task, parts, name, ends):
    path = task('<Sequence><RemoveObject object="basket"/><Sleep msec="100"/></Sequence>')
    made = prepare(RunRequest(TreeSource("task", "xml", path=path)), parts)
    told = []
    reloader = Reloader(made.request.tree, known_behaviours(parts), told.append)
    edited = path.read_text().replace("basket", name).replace("100", "30")
    editor = Editor(path, 3, edited)
    made.execute([editor, reloader])
    assert [line.removeprefix(str(path)).strip() for line in told] == [ends]
    assert made.station.cell.time == pytest.approx(0.1 if name == "baskt" else 0.05, abs=0.02)


def test_a_key_that_an_edit_declares_gets_its_default_or_is_told(tmp_path):
    made, _ = run(tmp_path, document(port='<input_port name="fresh" default="9"/>'))
    assert (made.tree.blackboard["fresh"], made.tree.blackboard["note"]) == (9, "wild")
    _, told = run(tmp_path, document(port='<input_port name="fresh"/>'))
    assert any("needs --set fresh=VALUE" in line for line in told)


def test_only_documents_can_be_watched():
    with pytest.raises(BtManipError, match="is a Python function"):
        Reloader(TreeSource("x.py:f", "python"), BehaviourRegistry(), print)
