"""Trees of 256 levels do all that others do; deeper ones are one error."""

import sys

import py_trees
import pytest

from bt_manip.bt import (
    AlwaysSuccess,
    BehaviourRegistry,
    Inverter,
    Sequence,
    Tree,
    draw_dot,
    draw_svg,
    draw_text,
    instance_to_xml,
    tree_to_xml,
)
from bt_manip.bt.loading import read_tree_text
from bt_manip.bt.xml.source import parse_source
from bt_manip.bt.xml.writer import write_source
from bt_manip.exceptions import TreeError
from bt_manip_convert import to_python

LEAF = '<Sleep msec="1000"/>'
PARENTS = {
    "ReactiveSequence": ('<ReactiveSequence _while="true">', "</ReactiveSequence>"),
    "Retry": ('<RetryUntilSuccessful num_attempts="2">', "</RetryUntilSuccessful>"),
    "TryCatch": ("<TryCatch>", "<AlwaysSuccess/></TryCatch>"),
}


@pytest.fixture(autouse=True)
def a_new_interpreter():
    """Set the recursion limit that a new interpreter has: deep trees raise it."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(1000)
    yield
    sys.setrecursionlimit(before)


def nested(levels, opening="<Inverter>", closing="</Inverter>"):
    """Write a tree of so many levels, the leaf included."""
    body = opening * (levels - 1) + LEAF + closing * (levels - 1)
    return f'<root BTCPP_format="4"><BehaviorTree ID="A">{body}</BehaviorTree></root>'


def nested_subtrees(levels):
    """Write a tree of so many levels, each a sub-tree but for the leaf."""
    trees = [
        f'<BehaviorTree ID="T{i}"><SubTree ID="T{i + 1}"/></BehaviorTree>'
        for i in range(levels - 1)
    ]
    last = f'<BehaviorTree ID="T{levels - 1}">{LEAF}</BehaviorTree>'
    return '<root BTCPP_format="4" main_tree_to_execute="T0">' + "".join([*trees, last]) + "</root>"


def do_everything(tree, registry):
    tree.observers.append(lambda *args: None)
    tree.tick()
    tree.set_state(tree.get_state())
    tree.halt()
    tree.tick()
    for draw in (draw_text, draw_dot, draw_svg, Tree._repr_svg_, instance_to_xml):
        assert draw(tree)
    assert tree_to_xml(tree, registry, model=True)


@pytest.mark.parametrize("parent", PARENTS)
def test_a_tree_of_256_levels_runs_and_is_drawn_and_written(parent):
    reading = read_tree_text(nested(256, *PARENTS[parent]), BehaviourRegistry())

    assert not reading.errors
    do_everything(reading.tree, reading.registry)


def test_256_levels_of_sub_trees_run_and_are_drawn_and_written():
    reading = read_tree_text(nested_subtrees(256), BehaviourRegistry())

    do_everything(reading.tree, reading.registry)
    compile(to_python(reading), "tree.py", "exec")


@pytest.mark.parametrize(
    "text",
    [nested(257), nested(490), nested_subtrees(257), nested_subtrees(1000)],
    ids=["257", "490", "257 sub-trees", "1000 sub-trees"],
)
def test_a_deeper_tree_is_one_error(text):
    reading = read_tree_text(text, BehaviourRegistry())

    assert reading.tree is None
    assert [error.message for error in reading.problems] == ["nested deeper than 256 levels"]


@pytest.mark.parametrize("levels", [257, 3000])
def test_a_deeper_tree_of_python_is_refused(levels):
    def deep():
        node = AlwaysSuccess()
        for i in range(levels - 1):
            node = py_trees.decorators.Inverter("i", node) if i % 2 else Sequence(node)
        return node

    with pytest.raises(TreeError, match="is nested deeper than 256 levels"):
        Tree(deep())
    with pytest.raises(TreeError, match="is nested deeper than 256 levels"):
        tree_to_xml(deep(), BehaviourRegistry())


def test_a_mixed_tree_of_256_levels_of_python_runs():
    node = AlwaysSuccess()
    for i in range(255):
        node = py_trees.decorators.Inverter("i", node) if i % 2 else Inverter(node)
    tree = Tree(node)

    assert tree.tick().name == "FAILURE"
    assert [node.name for node in tree.root.tick()]


def test_a_document_as_deep_as_the_engine_reads_is_formatted():
    text = write_source(parse_source(nested(495)))

    assert text.count("<Inverter>") == 494
