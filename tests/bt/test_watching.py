"""A tree follows the edits of its files, and a broken file changes nothing."""

import os

import pytest

from bt_manip.bt import BehaviourRegistry, NodeStatus, Script, Tree, TreeWatch, load_tree
from bt_manip.exceptions import TreeError

TEXT = (
    '<root main_tree_to_execute="Main"><BehaviorTree ID="Main"><Sequence><Script code="{}"/>'
    '<Sleep msec="100"/></Sequence></BehaviorTree></root>'
)


class Files:
    def __init__(self, folder):
        self.file = folder / "tree.xml"
        self.edits = 0
        self.write("n := 1")
        self.registry = BehaviourRegistry()
        self.tree = load_tree(self.file, self.registry, clock=lambda: 0.0)
        self.watch = TreeWatch(self.tree, self.registry)

    def write(self, code, file=None):
        (file or self.file).write_text(TEXT.format(code))
        self.edits += 1
        os.utime(file or self.file, ns=(self.edits, self.edits))


@pytest.fixture
def files(tmp_path):
    return Files(tmp_path)


def test_an_edit_takes_over_and_the_blackboard_stays(files):
    files.tree.tick()
    assert files.watch.poll() is None
    assert files.tree.statuses()[0] == NodeStatus.RUNNING
    files.write("n += 10")
    reading = files.watch.poll()

    assert reading.errors == () and set(files.tree.statuses()) == {NodeStatus.IDLE}
    files.tree.tick()
    assert files.tree.blackboard["n"] == 11
    assert files.watch.poll() is None


def test_a_broken_file_changes_nothing_and_says_what_is_wrong(files):
    files.tree.tick()
    files.write("n +")
    reading = files.watch.poll()

    assert "expected an operand" in str(reading.errors[0])
    assert files.tree.statuses()[0] == NodeStatus.RUNNING
    assert files.watch.poll() is None
    files.write("n := 7")
    assert files.watch.poll().errors == ()


def test_a_file_that_is_gone_for_a_moment_is_waited_for(files):
    files.file.unlink()
    assert files.watch.poll() is None
    files.write("n := 3")
    assert files.watch.poll().errors == ()


def test_included_files_are_watched_too(tmp_path):
    part = tmp_path / "part.xml"
    part.write_text('<root><BehaviorTree ID="Part"><AlwaysSuccess/></BehaviorTree></root>')
    main = tmp_path / "main.xml"
    main.write_text(
        '<root main_tree_to_execute="Main"><include path="part.xml"/>'
        '<BehaviorTree ID="Main"><SubTree ID="Part"/></BehaviorTree></root>'
    )
    registry = BehaviourRegistry()
    tree = load_tree(main, registry)
    watch = TreeWatch(tree, registry)
    part.write_text('<root><BehaviorTree ID="Part"><AlwaysFailure/></BehaviorTree></root>')
    os.utime(part, ns=(1, 1))
    watch.poll()

    assert tree.tick() is NodeStatus.FAILURE


def test_a_tree_without_a_file_cannot_be_watched():
    with pytest.raises(TreeError, match="was not read from a file"):
        TreeWatch(Tree(Script(code="x := 1")), BehaviourRegistry())
