"""The XML of a running tree is the one that BehaviorTree.CPP sends to Groot2."""

import pytest
from lxml import etree
from py_trees.behaviours import Running

from bt_manip.bt import (
    AlwaysSuccess,
    Parallel,
    Sequence,
    SubTree,
    Tree,
    instance_to_xml,
    parse_tree,
    tree_instances,
)
from tests.bt.conftest import models_of


def without_order(element):
    """Give an element as tuples, its attributes without an order."""
    children = [without_order(child) for child in element]
    return element.tag, dict(element.attrib), children


def test_a_tree_has_the_xml_of_the_engine(engine_facts, bench):
    demo = (engine_facts / "groot2" / "demo.xml").read_text()
    ours = etree.fromstring(instance_to_xml(parse_tree(demo, bench.registry)))
    theirs = etree.parse(engine_facts / "groot2" / "fulltree.xml").getroot()

    assert dict(ours.attrib) == dict(theirs.attrib)
    trees = [[without_order(t) for t in root.iter("BehaviorTree")] for root in (ours, theirs)]
    assert trees[0] == trees[1]
    models, wanted = models_of(ours), models_of(theirs)
    assert models == {name: wanted[name] for name in models}
    assert {"Sequence", "Fallback", "Script", "Switch6", "Scripted"} <= models.keys()


def test_each_instance_of_a_sub_tree_has_its_own_uids_and_path(bench):
    tree = bench.tree(
        '<Sequence><SubTree ID="A" name="one"/>'
        '<SubTree ID="A" _autoremap="true" x="{y}"/></Sequence>',
        '<BehaviorTree ID="A"><SubTree ID="B" name="in"/></BehaviorTree>',
        '<BehaviorTree ID="B"><AlwaysSuccess _skipIf="x > 3"/></BehaviorTree>',
    )
    found = [(i.tree_id, i.path, [n.uid for n in i.nodes]) for i in tree_instances(tree)]
    assert found == [
        ("Main", "", [1, 2, 5]),
        ("A", "one", [3]),
        ("B", "one/in", [4]),
        ("A", "A::5", [6]),
        ("B", "A::5/in", [7]),
    ]
    root = etree.fromstring(instance_to_xml(tree))
    last = root.findall("BehaviorTree")[-1]
    assert dict(last[0].attrib) == {"name": "AlwaysSuccess", "_uid": "7", "_skipIf": "x > 3"}
    attributes = dict(root.find("BehaviorTree/Sequence")[1].attrib)
    assert attributes == {
        "ID": "A", "_fullpath": "A::5", "_uid": "5", "x": "{y}", "_autoremap": "true"
    }  # fmt: skip


@pytest.mark.parametrize("nested", [False, True])
def test_stock_py_trees_behaviours_have_an_element_and_a_model(nested):
    leaf = Running(name="wait & see")
    root = Parallel("both", leaf, SubTree("inner", AlwaysSuccess())) if nested else Sequence(leaf)
    document = etree.fromstring(instance_to_xml(Tree(root)))
    (element,) = document.iter("Running")
    assert dict(element.attrib) == {"name": "wait & see", "_uid": "2"}
    assert models_of(document)["Running"] == ("Action", {})
