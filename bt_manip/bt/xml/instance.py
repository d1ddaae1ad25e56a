"""The XML of a running tree, with the uid of each node, as Groot2 receives it."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.tree_node import NodeKind, TreeNode
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.xml.model import tree_nodes_model
from bt_manip.bt.xml.source import Element, make_element
from bt_manip.bt.xml.writer import write_element

if TYPE_CHECKING:
    from bt_manip.bt.tree import Tree


@dataclass
class TreeInstance:
    """The main tree, or one instance of a sub-tree.

    Attributes:
        tree_id: ID of its tree.
        path: Path of its blackboard scope; empty for the main tree.
        nodes: Its nodes, depth first; those of sub-trees inside are in other instances.
        element: Its ``<BehaviorTree>``.
    """

    tree_id: str
    path: str
    nodes: list[TreeNode] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Begin its element."""
        self.element = make_element("BehaviorTree", {"ID": self.tree_id, "_fullpath": self.path})


def tree_instances(tree: "Tree") -> list[TreeInstance]:
    """Return the main tree and all instances of sub-trees, in the order of their SubTree nodes."""
    paths = {id(scope): path for path, scope in tree.scopes.items()}
    instances = [TreeInstance(tree.tree_id, "")]
    places = [(instances[0].element, instances[0])]  # of the next nodes, the next one last
    for node in tree.nodes:
        parent, instance = places.pop()
        instance.nodes.append(node)
        path = paths.get(id(getattr(node, "inner_scope", None)), "")
        element = _element(node, path)
        parent.content.append(element)
        if node.kind is NodeKind.SUBTREE and node.children:
            inner = TreeInstance(element.get("ID") or "", path)
            instances.append(inner)
            places.append((inner.element, inner))
        else:
            places += [(element, instance)] * len(node.children)
    return instances


def instance_to_xml(tree: "Tree") -> str:
    """Write a running tree: each instance of a sub-tree, uids, ports with defaults, and models.

    The text is that of BehaviorTree.CPP's ``WriteTreeToXML`` for the same tree; the models are
    those of the nodes of the language and of the tree.
    """
    root = make_element("root", {"BTCPP_format": "4"})
    root.content += [instance.element for instance in tree_instances(tree)]
    registry = BehaviourRegistry()
    foreign = {}
    for node in tree.nodes:
        if isinstance(node, Node):
            registry.replace(type(node), node.registration)
        else:
            foreign[node.registration] = make_element(str(node.kind), {"ID": node.registration})
    model = tree_nodes_model(registry, built_in=True)
    model.content += [element for name, element in foreign.items() if name not in registry]
    root.content.append(model)
    return write_element(root) + "\n"


def _element(node: Any, path: str) -> Element:
    """Return the XML element of a node; inside a SubTree, the path is relative to its scope."""
    if node.kind is NodeKind.SUBTREE:
        given = {"ID": node.tree_id, "_fullpath": path, "_uid": str(node.uid), **node.remaps}
        if node.autoremap_text:
            given["_autoremap"] = node.autoremap_text
        return make_element("SubTree", {**given, **node.conditions})
    given = {"name": node.name, "_uid": str(node.uid)}
    for name in node.ports:
        try:
            text = node.port_text(name)
        except Exception:  # of a behaviour's own function that formats a value
            text = str(node.given[name])
        if text is not None:
            given[name] = text
    return make_element(node.registration, {**given, **node.conditions})
