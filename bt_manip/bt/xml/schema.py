"""An XML schema of all registered behaviours, for the completion of editors and for validation."""

from pathlib import Path
from typing import Final

from bt_manip.bt.nodes.node import CONDITIONS, Node, NodeKind
from bt_manip.bt.port_types import BOOL, PortType
from bt_manip.bt.ports import Port
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.xml.writer import escape

_TEMPLATE: Final = Path(__file__).with_name("tree.xsd")
"""The part of the schema that is the same for all registries."""


def tree_schema(registry: BehaviourRegistry) -> str:
    """Make an XML schema (XSD 1.0) of documents with the registered behaviours."""
    names = registry.names()
    elements = [f'      <xs:element name="{name}" type="{name}.node"/>' for name in names]
    types = [line for name in names for line in _node_type(name, registry.get(name))]
    schema = _TEMPLATE.read_text("utf-8")
    schema = schema.replace("      <!-- elements of the nodes -->", "\n".join(elements))
    return schema.replace("  <!-- types of the nodes -->", "\n".join(types))


def _node_type(name: str, cls: type[Node]) -> list[str]:
    lines = [f'  <xs:complexType name="{name}.node">', *_documentation(cls.summary(), "    ")]
    children = _children(cls)
    if children:
        lines.append(f'    <xs:group ref="node" {children}/>')
    if name == "SubTree":
        lines.append('    <xs:attribute name="ID" type="xs:string" use="required"/>')
        lines.append('    <xs:attribute name="_autoremap" type="boolean"/>')
    for port in cls.ports.values():
        lines += _attribute(port)
    for condition in CONDITIONS.values():
        lines.append(f'    <xs:attribute name="{condition}" type="xs:string"/>')
    lines += ['    <xs:attributeGroup ref="common"/>', "  </xs:complexType>"]
    return lines


def _children(cls: type[Node]) -> str:
    if cls.kind is NodeKind.DECORATOR:
        return 'minOccurs="1" maxOccurs="1"'
    if cls.kind is NodeKind.CONTROL:
        least = getattr(cls, "least_children", 1)
        most = getattr(cls, "most_children", None)
        return f'minOccurs="{least}" maxOccurs="{"unbounded" if most is None else most}"'
    return ""


def _attribute(port: Port) -> list[str]:
    use = ' use="required"' if port.mandatory else ""
    opening = f'    <xs:attribute name="{port.name}" type="{_type(port)}"{use}'
    if not port.doc:
        return [opening + "/>"]
    return [opening + ">", *_documentation(port.doc, "      "), "    </xs:attribute>"]


def _type(port: Port) -> str:
    kind: PortType = port.type
    if not port.reads:
        return "entry"
    if kind is BOOL:
        return "booleanOrEntry"
    return {"integer": "integerOrEntry", "real": "numberOrEntry"}.get(kind.family, "xs:string")


def _documentation(text: str, indent: str) -> list[str]:
    if not text:
        return []
    body = f"<xs:documentation>{escape(text, quotes=False)}</xs:documentation>"
    return [f"{indent}<xs:annotation>{body}</xs:annotation>"]
