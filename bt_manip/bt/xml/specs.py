"""Specifications: trees and nodes as the elements of a document describe them."""

from dataclasses import dataclass, field

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.script.parser import ParsedScript
from bt_manip.bt.xml.problem import Place, Problems
from bt_manip.bt.xml.source import Element


@dataclass
class SubTreeUse:
    """The tree that a ``<SubTree>`` names, and the entries that it hands to it.

    Attributes:
        tree_id: The ID of the inner tree.
        place: The place of the ID.
        remaps: The meaning of the inner keys, defaults of the tree's model included.
        autoremap: Whether all other keys mean the same outside, as text; False if not.
        problems: Findings about the remaps; they count unless a test replaces the node.
        stub: The placeholder of the inner tree, if it has one.
    """

    tree_id: str
    place: Place
    remaps: dict[str, str]
    autoremap: bool | str = False
    problems: Problems = field(default_factory=Problems)
    stub: "NodeSpec | None" = None


@dataclass
class NodeSpec:
    """A node as its element describes it, with the class that is registered for it.

    Attributes:
        element: The element, with its comments and attributes for editors.
        cls: The class.
        registration: The name under which the class is registered.
        name: The name that the element gives; None for that of its class or inner tree.
        ports: The texts of its ports by name; invalid ones are left out.
        scripts: The scripts around its tick by attribute; invalid ones are left out.
        children: Its children; those that cannot be read are left out.
        subtree: The inner tree of a ``<SubTree>``.
    """

    element: Element
    cls: type[Node]
    registration: str
    name: str | None = None
    ports: dict[str, str] = field(default_factory=dict)
    scripts: dict[str, ParsedScript] = field(default_factory=dict)
    children: "list[NodeSpec]" = field(default_factory=list)
    subtree: SubTreeUse | None = None

    @property
    def default_name(self) -> str:
        """The name of a node without a given one."""
        return self.registration if self.subtree is None else self.subtree.tree_id

    @property
    def label(self) -> str:
        """The name of the node."""
        return self.default_name if self.name is None else self.name


@dataclass
class TreeSpec:
    """A tree of a document.

    Attributes:
        root: Its root; None if it cannot be read.
        subtrees: The IDs of the trees that it names.
        problems: Findings about its elements; they count where the tree is built.
        is_too_deep: Whether elements were left out because they are nested too deep.
    """

    root: NodeSpec | None = None
    subtrees: list[str] = field(default_factory=list)
    problems: Problems = field(default_factory=Problems)
    is_too_deep: bool = False
