"""Making the nodes of a tree from a document."""

from typing import Any, NamedTuple

from py_trees.behaviour import Behaviour

from bt_manip.bt.goal import GOAL, NO_CELL, parse_goal, reads_cell
from bt_manip.bt.literals import parse_boolean
from bt_manip.bt.nodes.actions.script import ScriptPort
from bt_manip.bt.nodes.binding import MAX_DEPTH
from bt_manip.bt.nodes.declared import Declared
from bt_manip.bt.nodes.guard import Guard
from bt_manip.bt.nodes.node import CONDITIONS, RESERVED, Comment, Node, NodeKind
from bt_manip.bt.nodes.parent import Parent
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.nodes.test_node import TestNode, TestNodeConfig
from bt_manip.bt.ports import Port
from bt_manip.bt.script.parser import parse_script
from bt_manip.bt.stubs import stub_child
from bt_manip.bt.substitution import Substitutions, find_rule
from bt_manip.bt.xml.context import ReadingContext
from bt_manip.bt.xml.document import EXPLICIT, is_port_name
from bt_manip.bt.xml.problem import Place, hint
from bt_manip.bt.xml.source import Element, Text
from bt_manip.exceptions import BtManipError, ScriptError, TreeError, shortened

SCRIPTS = tuple(CONDITIONS.values())
MAX_NODES = 65_535  # Groot2 counts nodes with 16 bits


class _Position(NamedTuple):
    """The position of a node in the tree that is built.

    Attributes:
        trees: The IDs of the trees around it, the main tree first.
        prefix: The paths of the sub-trees around it.
        depth: Its level, from 1, sub-trees included.
    """

    trees: tuple[str, ...] = ()
    prefix: str = ""
    depth: int = 1


class Builder:
    """Makes nodes from elements, and collects the errors of the others.

    Attributes:
        enums: Numbers that scripts know by name.
        places: The element of each node that was made.
        built: The IDs of the trees that were made.
        stubbed: The description of each stub, with the number of its nodes.
        is_too_deep: Whether nodes were left out because they are nested too deep.
    """

    def __init__(self, context: ReadingContext, substitutions: Substitutions | None = None) -> None:
        """Prepare to make trees of a document for which the engine's rules were checked."""
        self._document = context.document
        self._registry = context.registry
        self._problems = context.problems
        self._dialect = context.dialect
        self._stubs = context.stubs
        self._strict = context.strict
        self._rules = substitutions or {}
        self._count = 0
        self.enums = self._registry.enums
        self.places: dict[int, Element] = {}
        self.built: dict[str, None] = {}
        self.stubbed: dict[str, int] = {}
        self.is_too_deep = False

    def build(self, tree_id: str, place: Place) -> Behaviour | None:
        """Make the nodes of a tree that was named at a place, those of its sub-trees included.

        Returns:
            The root; None if nothing could be made.
        """
        return self._tree(tree_id, place, _Position())

    def goal(self, tree_id: str) -> tuple[Node, ...]:
        """Make the conditions of a tree's goal; errors and warnings are collected."""
        element = self._document.trees.get(tree_id)
        attribute = None if element is None else element.attributes.get(GOAL)
        if element is None or attribute is None:
            return ()
        try:
            goal = parse_goal(attribute.value, self._registry)
        except TreeError as error:
            self._problems.error(attribute.value_place, f"{GOAL}: {error}")
            return ()
        stubbed = any(isinstance(condition, Declared) for condition in goal)
        if goal and not stubbed and not reads_cell(goal):
            self._problems.warning(attribute.value_place, f"{GOAL}: {NO_CELL}")
        self.places.update((id(condition), element) for condition in goal)
        return goal

    def add_error(self, node: Any, port: str, error: BtManipError) -> None:
        """Collect an error of binding, at the place of the port, or of the node without a port."""
        element = self.places.get(id(node))
        if element is None:
            self._problems.error(Place(self._document.file, 1, 1), str(error))
        elif element.name == "BehaviorTree":
            self._problems.error(element.place_of(GOAL), f"{GOAL}: {error}")
        elif port in element.attributes:
            self._problems.error(element.attributes[port].value_place, str(error))
        elif not (self._strict and port):  # the static checks report a missing port
            self._problems.error(element.place, str(error))

    def _tree(self, tree_id: str, place: Place, at: _Position) -> Behaviour | None:
        element = self._document.trees.get(tree_id)
        if element is None:
            near = hint(tree_id, self._document.trees)
            self._problems.error(place, f"no tree is named '{shortened(tree_id)}'{near}")
            return None
        if tree_id in at.trees:
            circle = " -> ".join([*at.trees[at.trees.index(tree_id) :], tree_id])
            self._problems.error(place, f"trees contain each other in a circle: {circle}")
            return None
        self.built[tree_id] = None
        children = element.children
        if len(children) != 1:
            return None
        return self._node(children[0], at._replace(trees=(*at.trees, tree_id)))

    def _node(self, element: Element, at: _Position) -> Behaviour | None:
        if at.depth > MAX_DEPTH:
            if not self.is_too_deep:
                self._problems.error(element.place, f"nested deeper than {MAX_DEPTH} levels")
            self.is_too_deep = True
            return None
        self._count += 1
        if self._count > MAX_NODES:
            if self._count == MAX_NODES + 1:
                self._problems.error(element.place, f"the tree has more than {MAX_NODES} nodes")
            return None
        uid = self._count
        if element.name == "SubTree" or (
            element.name in EXPLICIT and element.get("ID") == "SubTree"
        ):
            return self._subtree(element, at, uid)
        if element.name == "BehaviorTree":
            self._problems.error(element.place, "a <BehaviorTree> cannot stand inside another")
            return None
        explicit = element.name in EXPLICIT
        name = (element.get("ID") or "") if explicit else element.name
        if name not in self._registry:
            return None  # verified before: it was reported
        if not explicit and "ID" in element.attributes:
            self._problems.error(
                element.place_of("ID"),
                f"<{name}> says already which node it is; it has no attribute 'ID'",
            )
        cls = self._registry.get(name)
        label = self._label(element, name)
        given = self._ports(element, cls, name)
        scripts = self._scripts(element)
        path = at.prefix + label + (f"::{uid}" if label == name else "")
        rule = find_rule(self._rules, label, name, path) if self._rules else None
        below = at._replace(depth=at.depth + 1)
        children: list[Behaviour] = []
        for item in element.children:  # no comprehension: it would double the depth of calls
            child = self._node(item, below)
            if child is not None:
                children.append(child)
        return self._make(element, cls, name, label, given, scripts, children, rule)

    def _make(
        self,
        element: Element,
        cls: type[Node],
        name: str,
        label: str,
        given: dict[str, Any],
        scripts: dict[str, str],
        children: list[Behaviour],
        rule: str | TestNodeConfig | None,
    ) -> Behaviour | None:
        node: Node
        try:
            if isinstance(rule, TestNodeConfig):
                node = TestNode(label, config=rule, replaced=cls, orphans=tuple(children), **given)
            else:
                replaced = cls
                if rule is not None:
                    cls = self._registry.get(rule)
                name_given = element.get("name")
                ports = given if rule is None else {}
                if issubclass(cls, Parent):
                    if cls.kind is NodeKind.DECORATOR and len(children) != 1:
                        if rule is not None:
                            count = len(children)
                            self._problems.error(
                                element.place, f"{rule} cannot replace it: it has {count} children"
                            )
                        return None  # else it was reported when the form was verified
                    node = cls(name_given, *children, **ports)
                else:
                    node = cls(name_given, **ports)
                    if not hasattr(node, "children"):
                        raise TypeError("its class has an __init__ that does not call super's")
                    node.orphans = tuple(children)
                if rule is not None:
                    node.ports = replaced.ports  # type: ignore[misc]
                    node._start_ports(given)
        except (BtManipError, TypeError) as error:
            self._problems.error(element.place, f"{name}: {error}")
            return None
        if isinstance(node, Declared):
            self._note(node, str(node.kind))
        node.registration = name
        node.name = label
        self._dress(node, element, scripts)
        return node

    def _note(self, node: Node, kind: str) -> None:
        text = f"{node.registration} ({kind}, {node.effect})"  # type: ignore[attr-defined]
        self.stubbed[text] = self.stubbed.get(text, 0) + 1

    def _dress(self, node: Node, element: Element, scripts: dict[str, str]) -> None:
        node.conditions = scripts
        if scripts:
            node._node_guard = Guard(scripts, double_quotes=self._dialect.double_quotes)
        if isinstance(node, ScriptPort):
            node.double_quotes = self._dialect.double_quotes
        node.attributes = {
            key: attribute.value
            for key, attribute in element.attributes.items()
            if key not in RESERVED and not is_port_name(key)
        }
        if element.name in EXPLICIT:
            node._node_tag = element.name
        index = 0
        for item in element.content:
            if isinstance(item, Element):
                index += 1
            else:
                kind = "text" if isinstance(item, Text) else item.kind
                node._node_comments.append((index, Comment(item.text, kind)))
        self.places[id(node)] = element

    def _label(self, element: Element, default: str) -> str:
        label = element.get("name")
        if label is None:
            return default
        if any((ord(c) < 32 and c not in "\t\n\r") or ord(c) == 127 for c in label):
            self._problems.error(
                element.place_of("name"), "the name of a node cannot contain control characters"
            )
        return label

    def _ports(self, element: Element, cls: type[Node], name: str) -> dict[str, Any]:
        given: dict[str, Any] = {}
        for key, attribute in element.attributes.items():
            if not is_port_name(key):
                continue
            port = cls.ports.get(key)
            if port is None:
                near = hint(key, [*cls.ports, "name", *SCRIPTS])
                self._problems.error(
                    attribute.place, f"{name} has no port '{shortened(key)}'{near}"
                )
                continue
            if self._check_literal(port, attribute.value, attribute.value_place):
                given[key] = attribute.value
        return given

    def _check_literal(self, port: Port, text: str, place: Place) -> bool:
        """Return whether a port takes a text; report it if it does not."""
        if len(text) >= 3 and text[0] == "{" and text[-1] == "}":
            return True
        type = port.type
        if not type.strong or (type.is_enum and not self._strict):
            return True
        if type.is_enum and text in self._registry.enums:
            return True
        if type.parse is None:
            self._problems.error(
                place,
                f"port '{port.name}' takes no text, only an entry as {{key}}: "
                f"a {type.name} cannot be written as text",
            )
            return False
        try:
            type.parse(text)
        except Exception as error:  # a parser of a behaviour's own may raise anything
            self._problems.error(
                place,
                f"port '{port.name}': {error}; expected {type.name}, or an entry as {{key}}",
            )
            return False
        return True

    def _scripts(self, element: Element) -> dict[str, str]:
        scripts: dict[str, str] = {}
        for key in SCRIPTS:
            attribute = element.attributes.get(key)
            if attribute is None:
                continue
            try:
                parse_script(attribute.value, double_quotes=self._dialect.double_quotes)
            except ScriptError as error:
                self._problems.error(attribute.value_place, f"{key}: {error}")
            else:
                scripts[key] = attribute.value
        return scripts

    def _subtree(self, element: Element, at: _Position, uid: int) -> Behaviour | None:
        tree_id = element.get("ID")
        if not tree_id:
            return None
        label = self._label(element, tree_id)
        scripts = self._scripts(element)
        named = "name" in element.attributes
        path = at.prefix + label + ("" if named and label != tree_id else f"::{uid}")
        rule = find_rule(self._rules, label, "SubTree", path) if self._rules else None
        if rule is not None:
            return self._make(element, SubTree, "SubTree", label, {}, scripts, [], rule)
        remaps, autoremap = self._remaps(element, tree_id)
        inner = at.prefix + label + ("" if named else f"::{uid}") + "/"
        result = self._stubs and self._stubs.result_of_tree(tree_id, self._document)
        if result:
            child = stub_child(tree_id, result, remaps)
            self._note(child, "SubTree")
            self.places[id(child)] = element
        else:
            below = at._replace(prefix=inner, depth=at.depth + 1)
            child = self._tree(tree_id, element.place_of("ID"), below)
        if child is None:
            return None
        node = SubTree(
            label if named else None, child, tree_id=tree_id, remap=remaps, autoremap=autoremap
        )
        self._dress(node, element, scripts)
        return node

    def _remaps(self, element: Element, tree_id: str) -> tuple[dict[str, str], bool | str]:
        remaps = {
            key: attribute.value
            for key, attribute in element.attributes.items()
            if is_port_name(key)
        }
        autoremap: bool | str = False
        text = element.get("_autoremap")
        if text is not None:
            try:
                if parse_boolean(text):
                    autoremap = text
            except ValueError as error:
                self._problems.error(element.place_of("_autoremap"), f"_autoremap: {error}")
        model = self._document.models.get(tree_id)
        if model is not None and not autoremap:
            for name, default in model.items():
                if name in remaps:
                    continue
                if default is None:
                    self._problems.error(
                        element.place,
                        f"the sub-tree '{tree_id}' needs the port '{name}', as its model says",
                    )
                else:
                    remaps[name] = default
        return remaps, autoremap
