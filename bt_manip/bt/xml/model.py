"""The ``TreeNodesModel``: what Groot2's palette needs to know of the behaviours."""

from bt_manip.bt.nodes.node import Node
from bt_manip.bt.ports import Port
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.xml.elements import Attribute, Element, SourceComment, Text
from bt_manip.bt.xml.problem import Place

_NOWHERE = Place("<model>", 1, 1)


def tree_nodes_model(registry: BehaviourRegistry, *, built_in: bool = False) -> Element:
    """Make the model of all registered behaviours.

    Args:
        registry: The behaviours.
        built_in: Whether the nodes of the language are in it; editors know them already.

    Returns:
        A ``<TreeNodesModel>`` element.
    """
    model = _element("TreeNodesModel")
    for name in registry.names(built_in=built_in):
        cls = registry.get(name)
        if name == "SubTree":
            continue
        model.content.append(_node_model(name, cls))
    return model


def models_document(registry: BehaviourRegistry, *, built_in: bool = False) -> Element:
    """Make a ``<root>`` that holds nothing but the model."""
    root = _element("root", BTCPP_format="4")
    root.content.append(tree_nodes_model(registry, built_in=built_in))
    return root


def _node_model(name: str, cls: type[Node]) -> Element:
    element = _element(str(cls.kind), ID=name)
    for port in cls.ports.values():
        element.content.append(_port_model(port))
    summary = cls.summary()
    if summary:
        description = _element("description")
        description.content.append(Text(summary, _NOWHERE))
        element.content.append(description)
    return element


def _port_model(port: Port) -> Element:
    element = _element(f"{port.direction}_port", name=port.name, type=port.type.name)
    if port.default_text or (isinstance(port.default, str) and port.reads):
        _set(element, "default", port.default_text)
    if port.doc:
        element.content.append(Text(port.doc, _NOWHERE))
    return element


def _element(tag: str, **attributes: str) -> Element:
    content: list[Element | SourceComment | Text] = []
    element = Element(tag, _NOWHERE, content=content)
    for key, value in attributes.items():
        _set(element, key, value)
    return element


def _set(element: Element, name: str, value: str) -> None:
    element.attributes[name] = Attribute(name, value, _NOWHERE, _NOWHERE)
