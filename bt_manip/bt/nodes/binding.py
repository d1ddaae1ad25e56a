"""Giving the nodes of a tree their surroundings: runtime, scope, path and number."""

from dataclasses import dataclass, field

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.nodes.foreign import ForeignNode
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.parent import Link, Parent
from bt_manip.bt.nodes.subtree import SubTree
from bt_manip.bt.runtime import Runtime
from bt_manip.exceptions import TreeError


@dataclass
class Binding:
    """The nodes and scopes of a bound tree.

    Attributes:
        nodes: All nodes, depth first.
        scopes: The scopes by the path of their sub-tree, ``""`` for the root's.
    """

    nodes: list[Link] = field(default_factory=list)
    scopes: dict[str, Blackboard] = field(default_factory=dict)


def bind(root: Behaviour, runtime: Runtime, scope: Blackboard) -> Binding:
    """Give all nodes below and at `root` their surroundings.

    Args:
        root: The root, ours or a stock behaviour.
        runtime: What they share.
        scope: The blackboard scope of the root.

    Returns:
        What was bound.

    Raises:
        TreeError: If two sub-trees have the same path, or if a node stands twice in the tree.
    """
    binding = Binding(scopes={"": scope})
    link = root if isinstance(root, Node) else ForeignNode(root)
    _bind(link, runtime, scope, "", binding, set())
    return binding


def _bind(
    link: Link, runtime: Runtime, scope: Blackboard, prefix: str, binding: Binding, seen: set[int]
) -> None:
    if id(link) in seen:
        raise TreeError(f"'{link.name}' stands in the tree more than once")
    seen.add(id(link))
    binding.nodes.append(link)
    uid = len(binding.nodes)
    link.uid = uid
    link.path = prefix + link.name
    if link.name == link.registration or (isinstance(link, SubTree) and link.is_unnamed):
        link.path += f"::{uid}"
    link._node_runtime = runtime
    link._node_observers = runtime.observers
    if isinstance(link, Node):
        link._node_scope = scope
    if isinstance(link, SubTree):
        scope = link.make_scope(scope)
        prefix = link.path + "/"
        if link.path in binding.scopes:
            raise TreeError(
                f"two sub-trees have the path '{link.path}'; give one of them another name"
            )
        binding.scopes[link.path] = scope
    if isinstance(link, Parent):
        for child in link.links:
            _bind(child, runtime, scope, prefix, binding, seen)
    else:
        for behaviour in link.children:
            child = behaviour if isinstance(behaviour, Node) else ForeignNode(behaviour)
            _bind(child, runtime, scope, prefix, binding, seen)
