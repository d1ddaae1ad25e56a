"""Breakpoints by name, in the file of a tree, over edits and further runs."""

import pytest

from bt_manip.bt import BehaviourRegistry, read_tree
from bt_manip_view.page.breakpoints import Breakpoints, marked_paths, paths_of

MARKED = """
<root BTCPP_format="4" main_tree_to_execute="Main">
  <BehaviorTree ID="Main"><Sequence>
    <SubTree ID="Part" name="left"/><SubTree ID="Part" name="right"/>
    <Sleep msec="10" _break="false"/><Sleep name="last" msec="10" _break="true"/>
  </Sequence></BehaviorTree>
  <BehaviorTree ID="Part"><AlwaysSuccess name="marked" _break="true"/></BehaviorTree>
</root>
"""

NODES = [
    {"path": path, "name": name}
    for path, name in (
        ("Sequence::1", "Sequence"), ("left", "left"), ("left/Sleep::3", "Sleep"),
        ("right", "right"), ("right/Sleep::5", "Sleep"),
    )
]  # fmt: skip


@pytest.fixture
def reading(tmp_path):
    path = tmp_path / "marked.xml"
    path.write_text(MARKED)
    return read_tree(path, BehaviourRegistry())


def test_an_attribute_of_a_node_marks_it_in_each_use_of_its_tree_without_a_warning(reading):
    assert not reading.problems
    assert marked_paths(reading.usable_tree()) == {"left/marked", "right/marked", "last"}


@pytest.mark.parametrize(
    ("name", "paths"),
    [
        ("left", {"left"}),
        ("Sleep", {"left/Sleep::3", "right/Sleep::5"}),
        ("left/Sleep", {"left/Sleep::3"}),
        ("right/Sleep::5", {"right/Sleep::5"}),
        ("eft/Sleep", set()),
    ],
)
def test_a_name_a_path_or_its_end_names_nodes(name, paths):
    assert paths_of(name, NODES) == paths


def test_each_tree_has_its_own_and_keeps_them():
    points = Breakpoints()
    points.names = ("left",)
    points.show("first", NODES, {"right"})
    assert points.paths == {"left", "right"}
    points.choose({"right/Sleep::5"})
    points.show("second", NODES[:2], ())
    assert points.paths == {"left"}
    points.show("first", NODES, {"right"})  # again: those that were removed stay removed
    assert points.paths == {"right/Sleep::5"}


def test_they_stay_at_their_nodes_when_an_edit_renumbers_them():
    points = Breakpoints()
    points.show("tree", NODES, ())
    points.choose({"right/Sleep::5"})
    added = {"path": "new", "name": "new"}
    later = [{**node, "path": node["path"].replace("5", "6")} for node in NODES[2:]]
    points.show("tree", [*NODES[:2], added, *later], ())
    assert points.paths == {"right/Sleep::6"}
