"""The dialect of MoveIt Pro's objectives."""

from pathlib import Path

from bt_manip.bt import Dialect, Element, Problems
from bt_manip_moveit_pro.for_each import ForEach, ForEachUntilSuccess
from bt_manip_moveit_pro.mapping import LeafMapping
from bt_manip_moveit_pro.nodes import LEAVES
from bt_manip_moveit_pro.repeat_unless_failure import (
    RepeatUnlessFailureEachTick,
    RepeatUnlessFailureWithinTick,
)

CONTROLS = {
    cls.__name__: cls
    for cls in (
        ForEach,
        ForEachUntilSuccess,
        RepeatUnlessFailureEachTick,
        RepeatUnlessFailureWithinTick,
    )
}

METADATA = frozenset(("subcategory", "runnable"))
"""Attributes of ``<Metadata>`` in MoveIt Pro's models; other tools write other ones."""

NODES = {**CONTROLS, **{cls.__name__: cls for cls in LEAVES}}


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
