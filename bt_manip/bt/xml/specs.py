"""Reading the elements of trees: each element becomes the checked specification of a node.

This is the place that knows how a document writes a node, its ports, scripts and remaps. The
builder makes nodes of specifications and looks at no element.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field

from bt_manip.bt.literals import parse_boolean
from bt_manip.bt.nodes.binding import MAX_DEPTH
from bt_manip.bt.nodes.declared import declare
from bt_manip.bt.nodes.node import CONDITIONS, Comment, Node
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.ports import Port
from bt_manip.bt.script.parser import ParsedScript, parse_script
from bt_manip.bt.xml.context import ReadingContext
from bt_manip.bt.xml.document import EXPLICIT, editor_attributes, node_name, port_attributes
from bt_manip.bt.xml.problem import Place, Problems
from bt_manip.bt.xml.source import Attribute, Element, Text
from bt_manip.exceptions import ScriptError

SCRIPTS = tuple(CONDITIONS.values())


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
        element: The element, for the places of problems.
        cls: The class.
        registration: The name under which the class is registered.
        kind: Its kind, for the list of stubs.
        name: The name that the element gives; None for that of its class or inner tree.
        ports: The texts of its ports by name; invalid ones are left out.
        scripts: The scripts around its tick by attribute; invalid ones are left out.
        children: Its children; those that cannot be read are left out.
        subtree: The inner tree of a ``<SubTree>``.
        tag: The element's name, if that is not the registered one: ``Action``.
        attributes: Attributes for editors only.
        comments: Comments and texts, each with the index of the child that follows.
    """

    element: Element
    cls: type[Node]
    registration: str
    kind: str
    name: str | None = None
    ports: dict[str, str] = field(default_factory=dict)
    scripts: dict[str, ParsedScript] = field(default_factory=dict)
    children: "list[NodeSpec]" = field(default_factory=list)
    subtree: SubTreeUse | None = None
    tag: str | None = None
    attributes: dict[str, str] = field(default_factory=dict)
    comments: list[tuple[int, Comment]] = field(default_factory=list)

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
    """

    root: NodeSpec | None = None
    subtrees: list[str] = field(default_factory=list)
    problems: Problems = field(default_factory=Problems)


def read_trees(context: ReadingContext, tree_ids: Iterable[str]) -> dict[str, TreeSpec]:
    """Read trees of a document by their IDs, and all trees that they name as sub-trees.

    The engine's rules were checked before: elements that violate them are left out in silence.
    """
    specs: dict[str, TreeSpec] = {}
    waiting = list(tree_ids)
    while waiting:
        tree_id = waiting.pop()
        element = context.document.trees.get(tree_id)
        if element is not None and tree_id not in specs:
            specs[tree_id] = spec = _TreeReader(context).read(element)
            waiting += spec.subtrees
    return specs


class _TreeReader:
    """Reads the elements of one tree.

    Args:
        context: The document and the names that it may use.
    """

    def __init__(self, context: ReadingContext) -> None:
        self._context = context
        self._spec = TreeSpec()
        self._problems = self._spec.problems

    def read(self, tree: Element) -> TreeSpec:
        roots = tree.children
        if len(roots) == 1:
            self._spec.root = self._node(roots[0], 1)
        return self._spec

    def _node(self, element: Element, depth: int) -> NodeSpec | None:
        name = node_name(element)
        if name == "SubTree":
            return self._subtree(element)
        if element.name == "BehaviorTree":
            self._problems.error(element.place, "a <BehaviorTree> cannot stand inside another")
            return None
        if name not in self._context.registry:
            return None
        if element.name not in EXPLICIT and "ID" in element.attributes:
            self._problems.error(
                element.place_of("ID"),
                f"<{name}> says already which node it is; it has no attribute 'ID'",
            )
        cls = self._context.registry.get(name)
        spec = self._spec_of(element, cls, name)
        for key, attribute in port_attributes(element).items():
            port = cls.ports.get(key)
            if port is None:
                self._problems.unknown(
                    attribute.place, f"{name} has no port", key, [*cls.ports, "name", *SCRIPTS]
                )
            elif self._is_valid(port, attribute):
                spec.ports[key] = attribute.value
        if depth > MAX_DEPTH:  # the builder reports it
            return spec
        for item in element.children:  # no comprehension: it would double the depth of calls
            child = self._node(item, depth + 1)
            if child is not None:
                spec.children.append(child)
        return spec

    def _spec_of(self, element: Element, cls: type[Node], registration: str) -> NodeSpec:
        """Read the part of an element that is the same for nodes and sub-trees."""
        spec = NodeSpec(element, cls, registration, str(cls.kind), element.get("name"))
        if any((ord(c) < 32 and c not in "\t\n\r") or ord(c) == 127 for c in spec.name or ""):
            self._problems.error(
                element.place_of("name"), "the name of a node cannot contain control characters"
            )
        for key in SCRIPTS:
            attribute = element.attributes.get(key)
            if attribute is not None:
                try:
                    spec.scripts[key] = parse_script(
                        attribute.value, double_quotes=self._context.dialect.double_quotes
                    )
                except ScriptError as error:
                    self._problems.error(attribute.value_place, f"{key}: {error}")
        spec.tag = element.name if element.name in EXPLICIT else None
        spec.attributes = editor_attributes(element)
        index = 0
        for item in element.content:
            if isinstance(item, Element):
                index += 1
            else:
                kind = "text" if isinstance(item, Text) else item.kind
                spec.comments.append((index, Comment(item.text, kind)))
        return spec

    def _is_valid(self, port: Port, attribute: Attribute) -> bool:
        """Return whether a port takes the text of an attribute; report it if it does not."""
        text, type = attribute.value, port.type
        if len(text) >= 3 and text[0] == "{" and text[-1] == "}":
            return True
        if not type.strong or (type.is_enum and not self._context.options.strict):
            return True
        if type.is_enum and text in self._context.registry.enums:
            return True
        if type.parse is None:
            message = (
                f"port '{port.name}' takes no text, only an entry as {{key}}: "
                f"a {type.name} cannot be written as text"
            )
        else:
            try:
                type.parse(text)
            except Exception as error:  # a parser of a behaviour's own may raise anything
                message = (
                    f"port '{port.name}': {error}; expected {type.name}, or an entry as {{key}}"
                )
            else:
                return True
        self._problems.error(attribute.value_place, message)
        return False

    def _subtree(self, element: Element) -> NodeSpec | None:
        tree_id = element.get("ID")
        if not tree_id:
            return None
        spec = self._spec_of(element, SubTree, "SubTree")
        remaps = {key: attribute.value for key, attribute in port_attributes(element).items()}
        spec.subtree = use = SubTreeUse(tree_id, element.place_of("ID"), remaps)
        text = element.get("_autoremap")
        if text is not None:
            try:
                use.autoremap = text if parse_boolean(text) else False
            except ValueError as error:
                use.problems.error(element.place_of("_autoremap"), f"_autoremap: {error}")
        for name, default in self._context.document.models.get(tree_id, {}).items():
            if use.autoremap or name in remaps:
                continue
            if default is None:
                use.problems.error(
                    element.place,
                    f"the sub-tree '{tree_id}' needs the port '{name}', as its model says",
                )
            else:
                remaps[name] = default
        stubs = self._context.options.stubs
        result = stubs and stubs.result_of_tree(tree_id, self._context.document)
        if result:
            leaf = declare(tree_id, ports=list(remaps), result=result)
            keys = {key: f"{{{key}}}" for key in remaps}
            use.stub = NodeSpec(element, leaf, tree_id, "SubTree", ports=keys)
        else:
            self._spec.subtrees.append(tree_id)
        return spec
