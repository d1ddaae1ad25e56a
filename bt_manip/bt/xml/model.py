"""The ``TreeNodesModel``: the names and ports of the behaviours, for Groot2's palette."""

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.ports import Port
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.xml.source import NOWHERE, Element, Text, make_element


def tree_nodes_model(registry: BehaviourRegistry, *, built_in: bool = False) -> Element:
    """Make the ``<TreeNodesModel>`` of all behaviours, if wanted of those of the language, too."""
    model = make_element("TreeNodesModel")
    for name in registry.names(built_in=built_in):
        cls = registry.get(name)
        if name == "SubTree":
            continue
        model.content.append(_node_model(name, cls))
    return model


def models_document(registry: BehaviourRegistry, *, built_in: bool = False) -> Element:
    """Make a ``<root>`` that holds nothing but the model."""
    root = make_element("root", {"BTCPP_format": "4"})
    root.content.append(tree_nodes_model(registry, built_in=built_in))
    return root


def _node_model(name: str, cls: type[Node]) -> Element:
    element = make_element(str(cls.kind), {"ID": name})
    for port in cls.ports.values():
        element.content.append(_port_model(port))
    summary = cls.summary()
    if summary:
        description = make_element("description")
        description.content.append(Text(summary, NOWHERE))
        element.content.append(description)
    return element


def _port_model(port: Port) -> Element:
    element = make_element(f"{port.direction}_port", {"name": port.name, "type": port.type.name})
    if port.default_text or (isinstance(port.default, str) and port.reads):
        element.set("default", port.default_text)
    if port.doc:
        element.content.append(Text(port.doc, NOWHERE))
    return element
