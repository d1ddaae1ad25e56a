"""Making the nodes of a tree from the specifications that its elements were read to."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from py_trees.behaviour import Behaviour

from bt_manip.bt.goal import GOAL, NO_CELL, parse_goal, reads_cell
from bt_manip.bt.nodes.actions.script import ScriptPort
from bt_manip.bt.nodes.binding import MAX_DEPTH
from bt_manip.bt.nodes.declared import Declared
from bt_manip.bt.nodes.guard import Guard
from bt_manip.bt.nodes.node import Comment, Node, NodeKind
from bt_manip.bt.nodes.parent import Parent
from bt_manip.bt.nodes.test_node import TestNode, TestNodeConfig
from bt_manip.bt.substitution import Substitutions, find_rule
from bt_manip.bt.xml.document import EXPLICIT, editor_attributes
from bt_manip.bt.xml.problem import Place
from bt_manip.bt.xml.source import Element, Text
from bt_manip.bt.xml.specs import NodeSpec, ReadingContext, SubTreeUse, TreeSpec
from bt_manip.exceptions import BtManipError, TreeError

MAX_NODES = 65_535  # Groot2 counts nodes with 16 bits


class _Position(NamedTuple):
    """The position of a node: the IDs of the trees and the path around it, and its level."""

    trees: tuple[str, ...] = ()
    prefix: str = ""
    depth: int = 1


class Builder:
    """Makes nodes from their specifications, and collects the errors of those that it cannot make.

    Attributes:
        places: The element of each node that was made.
        built: The IDs of the trees that were made.
        stubbed: The description of each stub, with the number of its nodes.
        is_too_deep: Whether nodes were left out because they are nested too deep.
    """

    def __init__(
        self,
        context: ReadingContext,
        trees: Mapping[str, TreeSpec],
        substitutions: Substitutions | None = None,
    ) -> None:
        self._context = context
        self._problems = context.problems
        self._trees = trees
        self._rules = substitutions or {}
        self._count = 0
        self.places: dict[int, Element] = {}
        self.built: dict[str, None] = {}
        self.stubbed: dict[str, int] = {}
        self.is_too_deep = False

    def build(self, tree_id: str, place: Place) -> Behaviour | None:
        """Make the nodes of a tree and of its sub-trees; None, with errors, if that fails."""
        return self._tree(tree_id, place, _Position())

    def goal(self, tree_id: str) -> tuple[Node, ...]:
        """Make the conditions of a tree's goal; errors and warnings are collected."""
        element = self._context.document.trees.get(tree_id)
        attribute = None if element is None else element.attributes.get(GOAL)
        if element is None or attribute is None:
            return ()
        try:
            goal = parse_goal(attribute.value, self._context.registry)
        except TreeError as error:
            self._problems.error(attribute.value_place, f"{GOAL}: {error}")
            return ()
        stubbed = any(isinstance(condition, Declared) for condition in goal)
        if goal and not stubbed and not reads_cell(goal):
            self._problems.warning(attribute.value_place, f"{GOAL}: {NO_CELL}", "goal-without-cell")
        for condition in goal:
            self.places[id(condition)] = element
            condition._node_place = attribute.value_place
        return goal

    def add_error(self, node: Any, port: str, error: BtManipError) -> None:
        """Collect an error of binding, at the place of the port, or of the node without a port."""
        element = self.places.get(id(node))
        if element is None:
            self._problems.error(Place(self._context.document.file, 1, 1), str(error))
        elif element.name == "BehaviorTree":
            self._problems.error(element.place_of(GOAL), f"{GOAL}: {error}")
        elif port in element.attributes:
            self._problems.error(element.attributes[port].value_place, str(error))
        elif not (self._context.options.strict and port):  # the static checks report that
            self._problems.error(element.place, str(error))

    def _tree(self, tree_id: str, place: Place, at: _Position) -> Behaviour | None:
        tree = self._trees.get(tree_id)
        if tree is None:
            self._problems.unknown(place, "no tree is named", tree_id, self._context.document.trees)
            return None
        if tree_id in at.trees:
            circle = " -> ".join([*at.trees[at.trees.index(tree_id) :], tree_id])
            self._problems.error(place, f"trees contain each other in a circle: {circle}")
            return None
        self.built[tree_id] = None
        self._problems.extend(tree.problems)
        self.is_too_deep |= tree.is_too_deep
        if tree.root is None:
            return None
        return self._node(tree.root, at._replace(trees=(*at.trees, tree_id)))

    def _node(self, spec: NodeSpec, at: _Position) -> Behaviour | None:
        if at.depth > MAX_DEPTH:
            if not self.is_too_deep:
                self._problems.error(spec.element.place, f"nested deeper than {MAX_DEPTH} levels")
            self.is_too_deep = True
            return None
        self._count += 1
        if self._count > MAX_NODES:
            if self._count == MAX_NODES + 1:
                self._problems.error(
                    spec.element.place, f"the tree has more than {MAX_NODES} nodes"
                )
            return None
        label, number = at.prefix + spec.label, f"::{self._count}"
        path = label + number if spec.label == spec.default_name else label
        rule = find_rule(self._rules, spec.label, spec.registration, path) if self._rules else None
        below = at._replace(depth=at.depth + 1)
        children: list[Behaviour] = []
        if spec.subtree is not None and rule is None:
            prefix = label + (number if spec.name is None else "") + "/"
            root = self._inner_root(spec.subtree, below._replace(prefix=prefix))
            if root is None:
                return None
            children = [root]
        for inner in spec.children:  # no comprehension: it would double the depth of calls
            child = self._node(inner, below)
            if child is not None:
                children.append(child)
        return self._make(spec, children, rule)

    def _inner_root(self, use: SubTreeUse, at: _Position) -> Behaviour | None:
        self._problems.extend(use.problems)
        if use.stub is not None:
            return self._make(use.stub, [], None)
        return self._tree(use.tree_id, use.place, at)

    def _make(
        self, spec: NodeSpec, children: list[Behaviour], rule: str | TestNodeConfig | None
    ) -> Behaviour | None:
        """Make a node; None if it cannot be made, or if it was reported that it has no form."""
        node: Node
        try:
            cls = self._context.registry.get(rule) if isinstance(rule, str) else spec.cls
            ports = {} if isinstance(rule, str) else spec.ports
            if isinstance(rule, TestNodeConfig):
                orphans = tuple(children)
                node = TestNode(spec.label, config=rule, replaced=cls, orphans=orphans, **ports)
            elif spec.subtree is not None and rule is None:
                use = spec.subtree
                node = cls(
                    spec.name,
                    *children,
                    tree_id=use.tree_id,
                    remap=use.remaps,
                    autoremap=use.autoremap,
                )
            elif issubclass(cls, Parent):
                if cls.kind is NodeKind.DECORATOR and len(children) != 1:
                    if rule is not None:
                        count = len(children)
                        self._problems.error(
                            spec.element.place,
                            f"{rule} cannot replace it: it has {count} children",
                        )
                    return None
                node = cls(spec.name, *children, **ports)
            else:
                node = cls(spec.name, **ports)
                if not hasattr(node, "children"):
                    raise TypeError("its class has an __init__ that does not call super's")
                node.orphans = tuple(children)
            if isinstance(rule, str):
                node.ports = spec.cls.ports  # type: ignore[misc]
                node._start_ports(spec.ports)
        except (BtManipError, TypeError) as error:
            self._problems.error(spec.element.place, f"{spec.registration}: {error}")
            return None
        node.registration, node.name = spec.registration, spec.label
        if isinstance(node, Declared):
            kind = "SubTree" if spec.element.name == "SubTree" else spec.cls.kind
            text = f"{spec.registration} ({kind}, {node.effect})"
            self.stubbed[text] = self.stubbed.get(text, 0) + 1
        if isinstance(node, ScriptPort):
            node.double_quotes = self._context.dialect.double_quotes
        node.conditions = {key: script.text for key, script in spec.scripts.items()}
        if spec.scripts:
            node._node_guard = Guard(spec.scripts)
        node.attributes = editor_attributes(spec.element)
        node._node_comments += _comments(spec.element)
        if spec.element.name in EXPLICIT:
            node._node_tag = spec.element.name
        self.places[id(node)] = spec.element
        node._node_place = spec.element.place
        return node


def _comments(element: Element) -> Iterator[tuple[int, Comment]]:
    """Yield comments and texts, each with the index of the child that follows."""
    index = 0
    for item in element.content:
        if isinstance(item, Element):
            index += 1
        else:
            yield index, Comment(item.text, "text" if isinstance(item, Text) else item.kind)
