"""Nodes and sub-trees that nobody has: declared, stubbed, converted and ticked."""

import os

import pytest

from bt_manip.bt import (
    BehaviourRegistry,
    Dialect,
    Libraries,
    Status,
    Stubs,
    TreeWatch,
    declare,
    parse_tree,
    read_tree,
    tree_to_xml,
)
from bt_manip.bt.loading import read_tree_text
from bt_manip.bt.xml import document
from bt_manip.exceptions import NodeError, TreeError

DOCUMENT = """\
<root BTCPP_format="4" main_tree_to_execute="Pick a part">
  <!-- how it is done -->
  <BehaviorTree ID="Pick a part" _description="Picks" _favorite="true">
    <Control ID="Sequence" name="top" _collapsed="false">
      <Action ID="DetectTags" image="{image}" poses="{poses}"/>
      <SubTree ID="Move to Place" place_name="Above" _collapsed="true"/>
      <Decorator ID="Repeat" num_cycles="2">
        <Action ID="MoveHand" name="close it" opening="0.7" _skipIf="2 &gt; 5"/>
      </Decorator>
    </Control>
  </BehaviorTree>
  <TreeNodesModel>
    <SubTree ID="Pick a part">
      <MetadataFields>
        <Metadata subcategory="Application - Basic"/>
      </MetadataFields>
    </SubTree>
  </TreeNodesModel>
</root>
"""
RECOVERY = """\
<root BTCPP_format="4">
  <BehaviorTree ID="Main">
    <RecoveryNode number_of_retries="6">
      <FollowPath path="{path}"/>
      <AlwaysSuccess/>
    </RecoveryNode>
  </BehaviorTree>
  %s
</root>
"""
MODELS = """\
<TreeNodesModel>
    <Action ID="FollowPath"><input_port name="path" type="Path">what to follow</input_port></Action>
    <Control ID="RecoveryNode"><input_port name="number_of_retries" default="1"/></Control>
  </TreeNodesModel>"""


@pytest.fixture
def registry():
    registry = BehaviourRegistry()
    registry.register_dialect(
        Dialect(
            "spaces",
            spaces_in_names=True,
            recognises=lambda root, problems: "_favorite" in root.children[0].attributes,
        )
    )
    return registry


def read(text, registry, **options):
    return read_tree_text(text, registry, **{"dialect": "auto", **options})


def test_unknown_leaves_and_sub_trees_succeed_where_stubs_are_asked_for(registry):
    errors = read(DOCUMENT, registry).errors
    assert len(errors) == 3 and "no node is named 'DetectTags'" in str(errors[0])

    reading = read(DOCUMENT, registry, stubs=Stubs(unknown=True))
    assert dict(reading.stubbed) == {
        "DetectTags (Action, succeeds)": 1,
        "Move to Place (SubTree, succeeds)": 1,
        "MoveHand (Action, succeeds)": 1,
    }
    tree = reading.usable_tree()
    for _ in range(2):
        tree.tick()
    assert tree.root.status is Status.SUCCESS


@pytest.mark.parametrize(
    ("name", "result"),
    [("MoveHand", "FAILURE"), ("MoveHand", "running"), ("Move to Place", "FAILURE")],
)
def test_a_stub_returns_what_is_asked(registry, name, result):
    tree = read(DOCUMENT, registry, stubs=Stubs(True, {name: result})).usable_tree()
    tree.tick()
    assert tree.root.status is Status[result.upper()]


def test_a_known_leaf_can_be_stubbed_too(registry):
    text = "<root><BehaviorTree><Sleep msec='1000'/></BehaviorTree></root>"
    tree = parse_tree(
        text, registry, main="BehaviorTree_0", stubs=Stubs(results={"Sleep": "FAILURE"})
    )
    tree.tick()
    assert tree.root.status is Status.FAILURE


def test_a_control_that_a_document_declares_cannot_be_ticked(registry):
    (error,) = read(RECOVERY % "", registry, stubs=Stubs(unknown=True)).errors
    assert "no node is named 'RecoveryNode'" in str(error) and error.place.line == 3

    reading = read(RECOVERY % MODELS, registry, stubs=Stubs())
    assert "RecoveryNode (Control, only declared)" in reading.stubbed
    with pytest.raises(NodeError, match="only declared.*RecoveryNode=Fallback"):
        reading.usable_tree().tick()


def test_a_file_without_models_is_refused(tmp_path):
    (tmp_path / "empty.xml").write_text("<root/>")
    with pytest.raises(TreeError, match="no <TreeNodesModel>"):
        Stubs(models=[tmp_path / "empty.xml"])


@pytest.mark.parametrize(
    ("results", "message"),
    [
        ({"RecoveryNode": "FAILURE"}, "is a Control"),
        ({"RecoveryNode": "Inverter"}, "Inverter is a Decorator"),
        ({"RecoveryNode": "Fallbak"}, "did you mean 'Fallback'"),
    ],
)
def test_a_stub_that_does_not_suit_is_refused(registry, results, message):
    with pytest.raises(TreeError, match=message):
        read(RECOVERY % MODELS, registry, stubs=Stubs(True, results))


def test_a_python_tree_with_declared_nodes_is_written_without_what_is_inside_sub_trees(registry):
    leaf = declare("Find it", "Condition", ["a-b", "path"])
    assert "Find it" in tree_to_xml(leaf(**{"a-b": "{x}", "path": "1"}), registry)


def test_a_condition_cannot_keep_running():
    with pytest.raises(TreeError, match="Condition cannot return 'RUNNING'"):
        declare("Seen", "Condition", result="RUNNING")


# Libraries


@pytest.fixture
def library(tmp_path):
    folder = tmp_path / "library"
    (folder / "deep").mkdir(parents=True)
    good = '<root><BehaviorTree ID="Good"><AlwaysSuccess/></BehaviorTree></root>'
    bad = '<root><BehaviorTree ID="Bad"><Unknown/></BehaviorTree></root>'
    (folder / "good.xml").write_text(good)
    (folder / "deep" / "bad.xml").write_text(bad)
    (folder / "package.xml").write_text("<package><name>x</name></package>")
    return folder


def using(tree_id, path):
    path.write_text(
        f'<root><BehaviorTree ID="Main"><SubTree ID="{tree_id}"/></BehaviorTree></root>'
    )
    return path


def test_folders_are_libraries_and_only_what_a_tree_uses_can_break_it(registry, library, tmp_path):
    good = read_tree(using("Good", tmp_path / "a.xml"), registry, libraries=[library])
    assert not good.errors
    bad = read_tree(using("Bad", tmp_path / "b.xml"), registry, libraries=[library])
    assert [error.place.file for error in bad.errors] == [str(library / "deep" / "bad.xml")]


def test_files_of_a_library_are_read_once(registry, library, tmp_path, monkeypatch):
    read = []
    original = document.read_bytes
    monkeypatch.setattr(document, "read_bytes", lambda p: read.append(p.name) or original(p))
    libraries = Libraries([library])
    for name in ("a.xml", "b.xml"):
        read_tree(using("Good", tmp_path / name), registry, libraries=libraries)
    assert sorted(read) == ["a.xml", "b.xml", "bad.xml", "good.xml", "package.xml"]


def test_a_watched_tree_and_its_library_are_read_anew(registry, library, tmp_path):
    path = using("Good", tmp_path / "a.xml")
    options = {"libraries": Libraries([library])}
    tree = read_tree(path, registry, **options).usable_tree()
    watch = TreeWatch(tree, registry, **options)
    assert watch.poll() is None
    good = library / "good.xml"
    good.write_text(good.read_text().replace("AlwaysSuccess", "AlwaysFailure"))
    os.utime(good, ns=(1, 1))
    assert not watch.poll().errors
    tree.tick()
    assert tree.root.status is Status.FAILURE
    path.write_text(path.read_text().replace('"Good"', '"Worse"'))
    os.utime(path, ns=(1, 1))
    assert "no tree is named 'Worse'" in str(watch.poll().errors[0])
