"""The dialect of MoveIt Pro's objectives."""

from pathlib import Path

from bt_manip.bt import Decorator, Dialect, Element, Node, Problems
from bt_manip_moveit_pro import (
    controls,
    interface,
    motions,
    planning_scene,
    poses,
    task_constructor,
    vectors,
    without_effect,
)
from bt_manip_moveit_pro.mapping import LeafMapping

MODULES = (
    controls,
    poses,
    vectors,
    interface,
    planning_scene,
    motions,
    task_constructor,
    without_effect,
)
BASES = ("SceneLeaf", "VectorLeaf", "Stage", "PlanExecution")
NODES = {
    name: cls
    for module in MODULES
    for name, cls in vars(module).items()
    if isinstance(cls, type) and issubclass(cls, Node) and name not in BASES
    if cls.__module__ == module.__name__
}
CONTROLS = {name for name, cls in NODES.items() if issubclass(cls, Decorator)}
METADATA = frozenset(("subcategory", "runnable"))
"""Attributes of ``<Metadata>`` in MoveIt Pro's models; other tools write other ones."""


def is_objective(root: Element, problems: Problems) -> bool:
    """Return whether a document has a trait that only MoveIt Pro's have."""
    for element in root.iterate():
        if element.name in CONTROLS or element.get("ID") in CONTROLS:
            return True
        if element.name == "Metadata" and element.attributes.keys() & METADATA:
            return True
        if element.name in ("BehaviorTree", "SubTree"):
            if element.attributes.keys() & {"_subtreeOnly", "_hardcoded", "_external"}:
                return True
    return False


MOVEIT_PRO = Dialect(
    "moveit-pro",
    "objectives of MoveIt Pro",
    nodes=NODES,
    libraries=(Path(__file__).with_name("library.xml"),),
    attributes=frozenset(
        "_subtreeOnly _hardcoded _category _displayName _external _runnable _tags "
        "_skipValidation".split()
    ),
    spaces_in_names=True,
    double_quotes=True,
    recognises=is_objective,
    read_mapping=LeafMapping.read,
)
