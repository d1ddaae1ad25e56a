"""Public collections of trees, where there are copies of them: they load and convert."""

import os
from pathlib import Path

import pytest

from bt_manip.bt import (
    Stubs,
    decode,
    parse_source,
    read_tree,
    tree_to_xml,
)
from bt_manip.bt.xml.source import Text
from bt_manip.plugins import load_plugins
from bt_manip.runner import known_behaviours
from bt_manip_convert import to_python

EXPLICIT = ("Action", "Condition", "Control", "Decorator")


@pytest.fixture(scope="module")
def registry():
    return known_behaviours(load_plugins().parts)


def collection(variable, content):
    folder = os.environ.get(variable)
    if folder is None:
        pytest.skip(f"{variable} does not name a folder with {content}")
    return Path(folder)


def canonical(element):
    """Give what an element says, its comments and the order of its attributes apart."""
    attributes = {a.name: a.value for a in element.attributes.values()}
    name = attributes.pop("ID") if element.name in EXPLICIT else element.name
    texts = [item.text.strip() for item in element.content if isinstance(item, Text)]
    children = [canonical(child) for child in element.children]
    return name, attributes, "".join(texts), children


def there_and_back(path, reading, registry, stubs):
    module = {}
    exec(compile(to_python(reading, stubs), path.stem, "exec"), module)
    before = parse_source(decode(path.read_bytes(), str(path))).root
    after = parse_source(tree_to_xml(module["document"](), registry)).root
    return canonical(before) == canonical(after)


def test_objectives_of_moveit_pro_load_and_convert(registry):
    folder = collection("MOVEIT_PRO_WORKSPACE", "PickNik's moveit_pro_example_ws")
    paths = [p for p in sorted(folder.rglob("*.xml")) if b"<BehaviorTree" in p.read_bytes()]
    stubs = Stubs(unknown=True)
    assert paths
    for path in paths:
        reading = read_tree(path, registry, dialect="auto", library=True, stubs=stubs)
        assert not reading.errors, reading.errors[0]
        assert there_and_back(path, reading, registry, stubs), path


def test_trees_of_nav2_load_with_its_list_of_nodes(registry):
    folder = collection("NAV2_REPOSITORY", "a copy of ros-navigation/navigation2")
    (models,) = folder.rglob("nav2_tree_nodes.xml")
    paths = sorted({p for p in folder.rglob("behavior_trees/*.xml") if "test" not in str(p)})
    stubs = Stubs(models=[models])
    wrong = []
    for path in paths:
        reading = read_tree(path, registry, dialect="auto", library=True, stubs=stubs)
        wrong += reading.errors
        assert reading.errors or there_and_back(path, reading, registry, stubs), path
    assert len(paths) >= 16
    assert [problem.message.split(";")[0] for problem in wrong] == ["no node is named 'inverter'"]
