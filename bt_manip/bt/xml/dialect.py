"""The dialects of tree documents: BehaviorTree.CPP's own, and MoveIt Pro's."""

import re
from dataclasses import dataclass
from typing import Final

from bt_manip.bt.nodes.decorators.for_each import ForEach, ForEachUntilSuccess
from bt_manip.bt.nodes.decorators.repeat_unless_failure import (
    RepeatUnlessFailureEachTick,
    RepeatUnlessFailureWithinTick,
)
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import TreeError, did_you_mean


@dataclass(frozen=True)
class Dialect:
    """The extensions of a dialect to the engine's rules.

    Attributes:
        name: Its name.
        spaces_in_names: Whether names of trees may contain spaces and the like.
        double_quotes: Whether strings in scripts may stand between double quotes.
        known_attributes: Attributes that its editor writes; they are no typing errors.
        nodes: Nodes that the dialect has beyond the engine's.
    """

    name: str
    spaces_in_names: bool = False
    double_quotes: bool = False
    known_attributes: frozenset[str] = frozenset()
    nodes: tuple[type[Node], ...] = ()

    def plain_name(self, name: str) -> str:
        """Return a name without the characters that the dialect allows in names."""
        return re.sub(r"[ .'/:?*|()]", "_", name) if self.spaces_in_names else name

    def extended(self, registry: BehaviourRegistry) -> BehaviourRegistry:
        """Return a registry that knows the dialect's nodes too."""
        missing = [cls for cls in self.nodes if cls.registration not in registry]
        if missing:
            registry = registry.copy()
            for cls in missing:
                registry.register(cls)
        return registry


EDITOR_ATTRIBUTES: Final = frozenset(
    {"_uid", "_fullpath", "_collapsed", "_description", "_favorite", "_autoremap", "_onHalted"}
)
"""Attributes that Groot2 and the engine's own writer put on nodes and trees."""

BTCPP: Final = Dialect("btcpp", known_attributes=EDITOR_ATTRIBUTES)
MOVEIT_PRO: Final = Dialect(
    "moveit-pro",
    spaces_in_names=True,
    double_quotes=True,
    known_attributes=EDITOR_ATTRIBUTES
    | {
        "_subtreeOnly",
        "_hardcoded",
        "_category",
        "_displayName",
        "_external",
        "_runnable",
        "_tags",
        "_skipValidation",
    },
    nodes=(
        ForEach,
        ForEachUntilSuccess,
        RepeatUnlessFailureEachTick,
        RepeatUnlessFailureWithinTick,
    ),
)
DIALECTS: Final = {dialect.name: dialect for dialect in (BTCPP, MOVEIT_PRO)}


def dialect_named(name: str, root: Element | None = None) -> Dialect:
    """Return a dialect by its name; ``auto`` recognises it.

    Args:
        name: ``btcpp``, ``moveit-pro`` or ``auto``.
        root: The document to recognise.

    Raises:
        TreeError: If there is no such dialect.
    """
    if name == "auto":
        return MOVEIT_PRO if root is not None and _is_moveit_pro(root) else BTCPP
    try:
        return DIALECTS[name]
    except KeyError:
        raise TreeError(
            f"no dialect is named '{name}'" + did_you_mean(name, [*DIALECTS, "auto"])
        ) from None


def _is_moveit_pro(root: Element) -> bool:
    own = {cls.__name__ for cls in MOVEIT_PRO.nodes}
    for element in root.iterate():
        if element.name in own or element.get("ID") in own:
            return True
        if element.name in ("MetadataFields", "Metadata"):
            return True
        if element.name in ("BehaviorTree", "SubTree"):
            if " " in (element.get("ID") or ""):
                return True
            if element.attributes.keys() & {"_subtreeOnly", "_hardcoded", "_external"}:
                return True
    return False
