"""The dialects of tree documents: BehaviorTree.CPP's own, and MoveIt Pro's."""

import re
from dataclasses import dataclass
from typing import Final

from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import TreeError, did_you_mean


@dataclass(frozen=True)
class Dialect:
    """What a dialect allows beyond the engine's rules.

    Attributes:
        name: Its name.
        spaces_in_names: Whether names of trees may contain spaces and the like.
        double_quotes: Whether strings in scripts may stand between double quotes.
        known_attributes: Attributes that its editor writes; they are no typing errors.
        aliases: Nodes of the engine by the names that the dialect gives them.
    """

    name: str
    spaces_in_names: bool = False
    double_quotes: bool = False
    known_attributes: frozenset[str] = frozenset()
    aliases: tuple[tuple[str, str], ...] = ()

    def plain_name(self, name: str) -> str:
        """Give a name without the characters that the dialect allows in names."""
        return re.sub(r"[ .'/:?*|()]", "_", name) if self.spaces_in_names else name

    def script(self, text: str) -> str:
        """Give a script in the engine's own form."""
        return _single_quoted(text) if self.double_quotes else text


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
        "_runnable",
        "_tags",
        "_skipValidation",
    },
)
DIALECTS: Final = {dialect.name: dialect for dialect in (BTCPP, MOVEIT_PRO)}


def dialect_named(name: str, root: Element | None = None) -> Dialect:
    """Give a dialect by its name; ``auto`` recognises it.

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
    for element in root.iterate():
        if element.name in ("MetadataFields", "Metadata"):
            return True
        if element.name in ("BehaviorTree", "SubTree"):
            if " " in (element.get("ID") or ""):
                return True
            if element.attributes.keys() & {"_subtreeOnly", "_hardcoded"}:
                return True
    return False


def _single_quoted(text: str) -> str:
    """Put strings between single quotes; a single quote inside stays only where that is legal."""
    pieces = re.split(r"('[^']*'|\"[^\"]*\")", text)
    for index in range(1, len(pieces), 2):
        piece = pieces[index]
        if piece[0] == '"' and "'" not in piece:
            pieces[index] = f"'{piece[1:-1]}'"
    return "".join(pieces)
