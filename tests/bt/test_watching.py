"""A tree follows the edits of its files; runner/test_reloading.py shows it in a run."""

import os

import pytest

from bt_manip.bt import BehaviourRegistry, Script, Tree, TreeWatch, load_tree
from bt_manip.exceptions import TreeError


def test_a_file_that_is_gone_for_a_moment_is_waited_for(tmp_path):
    file, text = tmp_path / "tree.xml", "<root><BehaviorTree><AlwaysSuccess/></BehaviorTree></root>"
    file.write_text(text)
    registry = BehaviourRegistry()
    watch = TreeWatch(load_tree(file, registry), registry)
    file.unlink()
    assert watch.poll() is None
    file.write_text(text)
    os.utime(file, ns=(1, 1))
    assert watch.poll().errors == ()


def test_a_tree_without_a_file_cannot_be_watched():
    with pytest.raises(TreeError, match="was not read from a file"):
        TreeWatch(Tree(Script(code="x := 1")), BehaviourRegistry())
