"""Binding the nodes of a tree to their runtime, scope, path and number."""

from collections.abc import Callable
from typing import Any, Final

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.nodes.tree_node import NodeKind, TreeNode, as_tree_node
from bt_manip.bt.port_types import STRING
from bt_manip.bt.ports import pointed_key
from bt_manip.bt.runtime import Runtime
from bt_manip.exceptions import BlackboardError, BtManipError, PortError, ScriptError, TreeError

OnProblem = Callable[[TreeNode, str, BtManipError], None]
"""Takes a node, the name of one of its ports or an empty text, and the problem with it."""


MAX_DEPTH: Final = 256
"""Levels of nodes in a tree, sub-trees included; for one tree of a document the engine's limit."""


def bind(
    root: Behaviour, runtime: Runtime, scope: Blackboard, on_problem: OnProblem | None = None
) -> "Binding":
    """Bind `root` and all nodes below it to a runtime and scopes, and declare their ports.

    Problems are collected by `on_problem`; without it the first error is raised.

    Raises:
        BtManipError: If the tree is invalid: two sub-trees with one path, a node that occurs twice
            in the tree, an entry that ports want with different types, or more than `MAX_DEPTH`
            levels.
    """
    binding = Binding(runtime, on_problem or _raise, scope)
    binding.add(as_tree_node(root), scope, "", 1, True)
    return binding


def _raise(node: TreeNode, port: str, error: BtManipError) -> None:
    raise error


class Binding:
    """The nodes and scopes of a bound tree.

    Attributes:
        nodes: All nodes, depth first.
        scopes: The scopes by the path of their sub-tree, ``""`` for the root's.
        depth: Its number of levels, sub-trees included.
    """

    def __init__(self, runtime: Runtime, on_problem: OnProblem, scope: Blackboard) -> None:
        self._runtime = runtime
        self._on_problem = on_problem
        self._seen: set[int] = set()
        self.nodes: list[Any] = []
        self.scopes = {"": scope}
        self.depth = 0

    def add(
        self, node: TreeNode, scope: Blackboard, prefix: str, depth: int, attached: bool
    ) -> None:
        """Bind a node and all below it; those that a test has replaced are not attached."""
        if depth > MAX_DEPTH:
            raise TreeError(f"'{node.name}' is nested deeper than {MAX_DEPTH} levels")
        if id(node) in self._seen:
            raise TreeError(f"'{node.name}' stands in the tree more than once")
        self._seen.add(id(node))
        self.depth = max(self.depth, depth)
        node.uid = len(self._seen)
        node.path = prefix + node.name
        if node.name == node.registration or getattr(node, "tree_id", None) == node.name:
            node.path += f"::{node.uid}"
        node._node_runtime = self._runtime
        if attached:
            self.nodes.append(node)
            node._node_observers = self._runtime.observers
        if isinstance(node, Behaviour):
            node._node_scope = scope  # type: ignore[attr-defined]
            self._declare(node, scope)
        if node.kind is NodeKind.SUBTREE:
            scope, prefix = self._enter(node, scope, prefix)
        for child in node.child_nodes:
            self.add(child, scope, prefix, depth + 1, attached)
        for orphan in node.orphans:
            if isinstance(orphan, TreeNode):
                self.add(orphan, scope, prefix, depth + 1, False)

    def _enter(self, node: Any, scope: Blackboard, prefix: str) -> tuple[Blackboard, str]:
        path = node.path if node.is_unnamed else prefix + node.name
        try:
            inner = node.make_scope(scope)
        except BlackboardError as error:
            self._on_problem(node, "", error)
            inner = Blackboard(scope)
        if path in self.scopes:
            self._on_problem(
                node,
                "name",
                TreeError(f"two sub-trees have the path '{path}'; give one of them another name"),
            )
        self.scopes[path] = inner
        return inner, path + "/"

    def _declare(self, node: Any, scope: Blackboard) -> None:
        """Declare the entries that the ports point to: the first strong type of a key counts.

        The engine's table of a node's ports hands them out last first; one key in two ports of a
        node gets the type of the last one.
        """
        for name, port in reversed(list(node.ports.items())):
            text = node.given.get(name)
            key = pointed_key(name, text) if isinstance(text, str) else None
            if key is None:
                continue
            entry = scope.entry(key)
            try:
                if entry is None:
                    scope.declare(key, port.type)
                elif (
                    entry.declared.strong
                    and port.type.strong
                    and entry.declared != port.type
                    and entry.declared is not STRING
                ):
                    raise PortError(
                        f"the entry '{key}' holds {entry.declared.name}, as it was declared "
                        f"first; the port '{name}' of {node.path} wants {port.type.name}"
                    )
            except (PortError, BlackboardError) as error:
                self._on_problem(node, name, error)
        try:
            node.check_ports()
        except (PortError, ScriptError) as error:
            self._on_problem(node, node.checked_port, error)
