"""The context of reading a document, and trees and nodes as its elements describe them."""

from dataclasses import dataclass, field

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.reading_options import ReadingOptions
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.script.parser import ParsedScript
from bt_manip.bt.xml.dialect import Dialect
from bt_manip.bt.xml.document import Document
from bt_manip.bt.xml.problem import Place, Problems
from bt_manip.bt.xml.source import Element


@dataclass
class ReadingContext:
    """A document, its included files and libraries read, and the findings about it.

    `known` are the behaviours that it may name; `registry` has stubs and the dialect's nodes, too.
    """

    document: Document
    known: BehaviourRegistry
    problems: Problems
    dialect: Dialect
    options: ReadingOptions
    registry: BehaviourRegistry = field(init=False)

    def __post_init__(self) -> None:
        """Add the nodes of the dialect, and declare the stubs."""
        self.known = self.registry = self.known.of_dialect(self.dialect)
        if self.options.stubs is not None:
            self.registry = self.options.stubs.extend(self.document, self.known, self.problems)


@dataclass
class SubTreeUse:
    """The tree that a ``<SubTree>`` names at a place, and the entries that it hands to it.

    Remaps include the defaults of the tree's model; `autoremap` is its text, or False. Findings
    about them count unless a test replaces the node. `stub` is the placeholder of the tree, if any.
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

    Invalid ports and scripts, and children that cannot be read, are left out. `name` is None for
    the name of the class or of the inner tree, which a ``<SubTree>`` has as `subtree`.
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
    """A tree of a document, without a root if that cannot be read, and the trees that it names.

    Findings about its elements count where the tree is built.
    """

    root: NodeSpec | None = None
    subtrees: list[str] = field(default_factory=list)
    problems: Problems = field(default_factory=Problems)
    is_too_deep: bool = False
