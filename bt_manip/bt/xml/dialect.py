"""Dialects of tree documents: what others write beyond the engine's rules, or differently."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.xml.problem import Problems
from bt_manip.bt.xml.source import Element
from bt_manip.exceptions import TreeError
from bt_manip.packages import suggestion

if TYPE_CHECKING:
    from bt_manip.bt.xml.document import Document

EDITOR_ATTRIBUTES: Final = frozenset(
    "_uid _fullpath _collapsed _description _favorite _autoremap _onHalted _break".split()
)
"""Attributes that Groot2, the engine's own writer and the page of a run put on nodes and trees."""


@dataclass(frozen=True)
class Dialect:
    """How some documents differ from those of BehaviorTree.CPP 4.

    Attributes:
        name: Its name, for ``--dialect``.
        summary: One line about it.
        nodes: Its nodes by name; in its documents they count, not those of others of the same name.
        without: Nodes of the language that its engine does not have; its documents may use their
            names for other nodes.
        libraries: Files and folders with the sub-trees that come with it.
        given: Entries of the blackboard that its program writes before a tree runs.
        attributes: Attributes that its editor writes, each with a ``_`` in front.
        spaces_in_names: Whether names of trees may contain spaces and the like.
        double_quotes: Whether strings in scripts may stand between double quotes.
        recognises: Returns whether a document, given by its ``<root>``, is of the dialect. It may
            add a warning that says why.
        translate: Rewrites the elements of a file, given by its ``<root>``, into those of
            BehaviorTree.CPP 4 and the dialect's `nodes`. The `Document` has the trees and models
            of all files. It adds errors for what has no meaning here.
        read_mapping: Reads the file of ``--map``: an object whose ``apply(document, problems)``
            replaces leaves and sub-trees by behaviours.
        to_version_4: Rewrites a file that was translated, so that the engine's own nodes do the
            same; errors say what they cannot do. For ``bt-manip tree convert --to xml``.
    """

    name: str
    summary: str = ""
    nodes: Mapping[str, type[Node]] = field(default_factory=dict)
    without: frozenset[str] = frozenset()
    libraries: tuple[Path, ...] = ()
    given: frozenset[str] = frozenset()
    attributes: frozenset[str] = frozenset()
    spaces_in_names: bool = False
    double_quotes: bool = False
    recognises: Callable[[Element, Problems], bool] = lambda root, problems: False
    translate: "Callable[[Element, Document, Problems], None]" = lambda root, whole, problems: None
    to_version_4: "Callable[[Element, Document, Problems], None]" = lambda root, whole, problems: (
        None
    )

    read_mapping: "Callable[[Path], Any] | None" = None

    def plain_name(self, name: str) -> str:
        """Return a name without the characters that the dialect allows in names."""
        return name.translate(_PLAIN) if self.spaces_in_names else name

    def knows(self, attribute: str) -> bool:
        """Return whether an attribute with a ``_`` in front is one of its editor's."""
        return attribute in EDITOR_ATTRIBUTES or attribute in self.attributes


_PLAIN: Final = str.maketrans(dict.fromkeys(" .'/:?*|()", "_"))
BTCPP: Final = Dialect("btcpp", "BehaviorTree.CPP 4")


def choose_dialect(
    name: str, root: Element, known: Mapping[str, Dialect], problems: Problems
) -> Dialect:
    """Return a known dialect by its name; ``auto`` for the one that recognises the ``<root>``.

    Raises:
        TreeError: If there is no such dialect.
    """
    if name == "auto":
        return next((one for one in known.values() if one.recognises(root, problems)), BTCPP)
    known = {BTCPP.name: BTCPP, **known}
    if name not in known:
        hint = suggestion("dialect", name, [*known, "auto"])
        raise TreeError(f"no dialect is named '{name}'{hint}")
    return known[name]
