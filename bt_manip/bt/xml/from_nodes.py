"""Writing a tree that was built in Python as a document."""

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeVar

from py_trees.behaviour import Behaviour

from bt_manip.bt.goal import CONTINUES, GOAL, RESULT_KEYS, TASK, goal_to_text
from bt_manip.bt.nodes.binding import MAX_DEPTH
from bt_manip.bt.nodes.declared import Declared
from bt_manip.bt.nodes.node import Comment, Node
from bt_manip.bt.nodes.parent import Parent
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.registry import BehaviourRegistry, name_problem
from bt_manip.bt.tree import Tree
from bt_manip.bt.xml.document import Document
from bt_manip.bt.xml.model import tree_nodes_model
from bt_manip.bt.xml.source import (
    NOWHERE,
    Element,
    Source,
    SourceComment,
    Text,
    make_element,
    parse_source,
)
from bt_manip.bt.xml.writer import write_element, write_source
from bt_manip.exceptions import BtManipError, TreeError


@dataclass(frozen=True)
class Raw:
    """A piece of a document as XML text, such as a ``<TreeNodesModel>``."""

    text: str


NodeT = TypeVar("NodeT", bound=Node)


def as_written(
    node: NodeT,
    *,
    tag: str | None = None,
    attributes: Mapping[str, str] | None = None,
    comments: Sequence[Comment] = (),
) -> NodeT:
    """Let a node keep the form that it has in a document, and return it.

    Args:
        node: The node.
        tag: The element, where it is not the node's own name: ``Action`` for ``<Action ID=...>``.
        attributes: Attributes for editors only, such as ``_collapsed``.
        comments: Comments inside the element of a leaf, or after the last child.
    """
    node._node_tag = tag
    node.attributes = dict(attributes or {})
    node._node_comments += [(len(node.children), comment) for comment in comments]
    return node


@dataclass(frozen=True)
class TreeDefinition:
    """A tree of a document.

    Attributes:
        tree_id: Its ID; empty for the only tree of a document that has none.
        root: Its root.
        attributes: Other attributes of its element.
        before: Comments before its root.
        after: Comments after it.
        goal: Conditions that hold when the tree has done its task.
    """

    tree_id: str
    root: Behaviour
    attributes: Mapping[str, str] = field(default_factory=dict)
    before: Sequence[Comment] = ()
    after: Sequence[Comment] = ()
    goal: Sequence[Node] = ()


@dataclass(frozen=True)
class TreeDocument:
    """A document made in Python: its trees, comments and other elements.

    Attributes:
        content: Trees, comments and other elements, in order.
        attributes: The attributes of ``<root>``.
        before: Comments before ``<root>``.
        after: Comments after it.
    """

    content: Sequence[TreeDefinition | Comment | Raw]
    attributes: Mapping[str, str] = field(default_factory=lambda: {"BTCPP_format": "4"})
    before: Sequence[Comment | Raw] = ()
    after: Sequence[Comment] = ()

    def main_tree(self) -> TreeDefinition:
        """Return the main tree; raise a `TreeError` if the document does not say which it is."""
        trees = [item for item in self.content if isinstance(item, TreeDefinition)]
        main = self.attributes.get("main_tree_to_execute")
        for tree in trees:
            if tree.tree_id == main or len(trees) == 1:
                return tree
        raise TreeError("the document does not say which of its trees runs")


def tree_to_xml(
    tree: Tree | Behaviour | TreeDocument | Document,
    registry: BehaviourRegistry,
    *,
    tree_id: str | None = None,
    model: bool = False,
) -> str:
    """Write a tree as a document.

    Args:
        tree: A tree, a root, a document, or a whole one made in Python. Of a tree that was read
            from a document, that document is written.
        registry: The names of the behaviours.
        tree_id: The ID of the main tree; by default the tree's own, or ``MainTree``.
        model: Whether to add the models of the behaviours, for Groot2's palette.

    Returns:
        The document.

    Raises:
        TreeError: If nodes have no form in XML; it names all of them. Also if a tree is deeper
            than 256 levels.
    """
    goal: Sequence[Node] = ()
    declared: dict[str, str] = {}
    if isinstance(tree, Tree) and tree.document is not None:
        tree = tree.document
    if isinstance(tree, Document):
        source = tree.source
        return write_source(_with_models(source, registry) if model else source)
    if isinstance(tree, Tree):
        tree_id = tree_id or (tree.tree_id if name_problem(tree.tree_id) is None else None)
        declared = {
            TASK: tree.given_task,
            RESULT_KEYS: " ".join(tree.results),
            CONTINUES: "true" if tree.continues else "",
        }
        goal, tree = tree.given_goal, tree.root
    writer = _Writer(registry)
    if isinstance(tree, TreeDocument):
        root = writer.document(tree)
        before = [_comment(item) for item in tree.before]
        after = [_comment(item) for item in tree.after]
    else:
        root = writer.trees(tree_id or "MainTree", tree, goal)
        for name, text in declared.items():
            if text:
                root.children[0].set(name, text)
        before, after = [], []
    if writer.problems:
        raise TreeError(
            "the tree has no form in XML:\n" + "\n".join(writer.problems), writer.problems
        )
    source = Source(root, before, after)
    return write_source(_with_models(source, registry) if model else source)


def _with_models(source: Source, registry: BehaviourRegistry) -> Source:
    """Return a copy of a document with the models of all behaviours that it does not model."""
    added = tree_nodes_model(registry)
    content = list(source.root.content)
    for index, item in enumerate(content):
        if isinstance(item, Element) and item.name == "TreeNodesModel":
            known = {model.get("ID") for model in item.children}
            missing = [model for model in added.children if model.get("ID") not in known]
            content[index] = replace(item, content=[*item.content, *missing])
            break
    else:
        content.append(added)
    return replace(source, root=replace(source.root, content=content))


def _comment(item: Comment | Raw) -> SourceComment | Text:
    if isinstance(item, Raw):
        return SourceComment(item.text, NOWHERE, "instruction")
    return Text(item.text, NOWHERE) if item.kind == "text" else SourceComment(item.text, NOWHERE)


class _Writer:
    def __init__(self, registry: BehaviourRegistry) -> None:
        self._registry = registry.copy()
        for dialect in registry.dialects.values():
            for name, cls in dialect.nodes.items():
                if name not in registry:
                    self._registry.replace(cls, name)
        self.problems: list[str] = []
        self._subtrees: deque[SubTree] = deque()
        self._written: dict[str, Element] = {}

    def document(self, document: TreeDocument) -> Element:
        root = make_element("root", dict(document.attributes))
        for item in document.content:
            if isinstance(item, TreeDefinition):
                given = {"ID": item.tree_id} if item.tree_id else {}
                element = make_element("BehaviorTree", {**given, **item.attributes})
                self._goal(element, item.goal)
                element.content += [_comment(comment) for comment in item.before]
                element.content.append(self._node(item.root, 1))
                element.content += [_comment(comment) for comment in item.after]
                root.content.append(element)
            elif isinstance(item, Raw):
                root.content.append(parse_source(item.text).root)
            else:
                root.content.append(_comment(item))
        return root

    def _goal(self, element: Element, goal: Sequence[Node]) -> None:
        if goal:
            try:
                element.set(GOAL, goal_to_text(goal, self._registry))
            except BtManipError as error:
                self.problems.append(str(error))

    def trees(self, main: str, behaviour: Behaviour, goal: Sequence[Node]) -> Element:
        root = make_element("root", {"BTCPP_format": "4", "main_tree_to_execute": main})
        self._written[main] = self._tree(main, behaviour)
        self._goal(self._written[main], goal)
        root.content.append(self._written[main])
        while self._subtrees:
            node = self._subtrees.popleft()
            element = self._tree(node.tree_id, node.children[0])
            known = self._written.setdefault(node.tree_id, element)
            if known is element:
                element.spaced = True
                root.content.append(element)
            elif write_element(known) != write_element(element):
                self.problems.append(
                    f"two different trees are called '{node.tree_id}'; give one another tree_id"
                )
        return root

    def _tree(self, tree_id: str, behaviour: Behaviour) -> Element:
        element = make_element("BehaviorTree", {"ID": tree_id})
        problem = name_problem(tree_id)
        if problem is not None or tree_id in self._registry:
            self.problems.append(
                f"tree '{tree_id}': its name {problem or 'is that of a node'}; give another tree_id"
            )
        element.content.append(self._node(behaviour, 1))
        return element

    def _node(self, behaviour: Behaviour, depth: int) -> Element:
        if depth > MAX_DEPTH:
            raise TreeError(f"'{_path(behaviour)}' is nested deeper than {MAX_DEPTH} levels")
        if isinstance(behaviour, SubTree):
            return self._subtree(behaviour)
        name = self._registry.name_of(type(behaviour))
        if name is None and isinstance(behaviour, Node) and behaviour.registration:
            known = isinstance(behaviour, Declared) or behaviour.registration in self._registry
            name = behaviour.registration if known else None
        if name is None or not isinstance(behaviour, Node):
            self.problems.append(
                f"'{_path(behaviour)}': {type(behaviour).__module__}.{type(behaviour).__name__} "
                "is not registered"
            )
            name = type(behaviour).__name__
        element = make_element(name)
        if not isinstance(behaviour, Node):
            element.content += [self._node(child, depth + 1) for child in behaviour.children]
            return element
        if behaviour._node_tag is not None:
            element.name = behaviour._node_tag
            element.set("ID", name)
        if behaviour.is_named:
            element.set("name", behaviour.name)
        for key in behaviour.given:
            self._port(element, behaviour, key)
        self._finish(element, behaviour)
        if isinstance(behaviour, Parent):
            element.content += [self._node(child, depth + 1) for child in behaviour.children]
        _insert_comments(element, behaviour)
        return element

    def _port(self, element: Element, node: Node, key: str) -> None:
        try:
            text = node.port_text(key)
        except Exception as error:  # a format function of a behaviour's own may raise anything
            self.problems.append(f"'{_path(node)}': port '{key}': {error}")
            return
        value = node.given[key]
        port = node.ports[key]
        if not isinstance(value, str) and port.type.strong and port.type.format is None:
            self.problems.append(
                f"'{_path(node)}': port '{key}': a {port.type.name} cannot be written as text"
            )
        element.set(key, text or "")

    def _finish(self, element: Element, node: Node) -> None:
        for key, text in {**node.conditions, **node.attributes}.items():
            element.set(key, text)

    def _subtree(self, node: SubTree) -> Element:
        element = make_element("SubTree", {"ID": node.tree_id})
        if not node.is_unnamed:
            element.set("name", node.name)
        for key, text in node.remaps.items():
            element.set(key, text)
        if node.autoremap_text:
            element.set("_autoremap", node.autoremap_text)
        self._finish(element, node)
        if node.children and not isinstance(node.children[0], Declared):
            self._subtrees.append(node)
        _insert_comments(element, node)
        return element


def _insert_comments(element: Element, node: Node) -> None:
    for index, comment in reversed(node._node_comments):
        element.content.insert(index, _comment(comment))


def _path(behaviour: Any) -> str:
    return getattr(behaviour, "path", "") or behaviour.name
