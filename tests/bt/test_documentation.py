"""The pages say what the code does."""

import re

import pytest

from bt_manip.behaviours import Grasp, Hover
from bt_manip.bt import BehaviourRegistry, parse_tree
from bt_manip.bt.nodes.node import CONDITIONS
from tools.node_reference import node_reference


@pytest.fixture
def page(repository):
    return (repository / "docs" / "tree-language.md").read_text(encoding="utf-8")


def test_the_table_of_each_node_covers_every_status_and_the_halt():
    reference = node_reference()
    for name in BehaviourRegistry().names():
        table = reference.partition(f"\n### {name}\n")[2].partition("\n###")[0]
        words = ["halt", "FAILURE" if name == "AlwaysFailure" else "SUCCESS"]
        if BehaviourRegistry().get(name).kind in ("Control", "Decorator", "SubTree"):
            words += ["FAILURE", "RUNNING", "SKIPPED"]
        if name.startswith("KeepRunning"):
            words.remove("SUCCESS")

        assert all(word in table for word in words), name


def test_every_script_around_a_tick_is_on_the_page(page):
    for name, attribute in CONDITIONS.items():
        assert f"| `{attribute}` | `{name}` |" in page


def test_the_tree_on_the_page_can_be_read(page):
    text = re.search(r"```xml\n(.*?)```", page, re.DOTALL)[1]
    registry = BehaviourRegistry([Hover, Grasp])

    assert parse_tree(text, registry, strict=False).tree_id == "Main"
