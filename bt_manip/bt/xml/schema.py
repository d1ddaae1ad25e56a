"""An XML schema of all registered behaviours, for the completion of editors and for validation."""

from typing import Final

from bt_manip.bt.nodes.node import CONDITIONS, Node, NodeKind
from bt_manip.bt.port_types import BOOL, PortType
from bt_manip.bt.ports import Port
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.xml.writer import escape

_HEAD: Final = """<?xml version="1.0" encoding="UTF-8"?>
<xs:schema xmlns:xs="http://www.w3.org/2001/XMLSchema" elementFormDefault="qualified">
  <xs:simpleType name="entry">
    <xs:restriction base="xs:string"><xs:pattern value="\\s*\\{.+\\}\\s*|="/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="boolean">
    <xs:restriction base="xs:string">
      <xs:pattern value="true|True|TRUE|false|False|FALSE|0|1"/>
    </xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="integer">
    <xs:restriction base="xs:string"><xs:pattern value="-?[0-9]+"/></xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="number">
    <xs:restriction base="xs:string">
      <xs:pattern value="-?([0-9]+\\.?[0-9]*|\\.[0-9]+)([eE][+\\-]?[0-9]+)?|-?inf|-?nan"/>
    </xs:restriction>
  </xs:simpleType>
  <xs:simpleType name="booleanOrEntry"><xs:union memberTypes="boolean entry"/></xs:simpleType>
  <xs:simpleType name="integerOrEntry"><xs:union memberTypes="integer entry"/></xs:simpleType>
  <xs:simpleType name="numberOrEntry"><xs:union memberTypes="number entry"/></xs:simpleType>
  <xs:attributeGroup name="common">
    <xs:attribute name="name" type="xs:string"/>
    <xs:anyAttribute namespace="##any" processContents="skip"/>
  </xs:attributeGroup>
  <xs:complexType name="port">
    <xs:simpleContent>
      <xs:extension base="xs:string">
        <xs:attribute name="name" type="xs:string" use="required"/>
        <xs:attribute name="type" type="xs:string"/>
        <xs:attribute name="default" type="xs:string"/>
      </xs:extension>
    </xs:simpleContent>
  </xs:complexType>
  <xs:complexType name="nodeModel">
    <xs:choice minOccurs="0" maxOccurs="unbounded">
      <xs:element name="input_port" type="port"/>
      <xs:element name="output_port" type="port"/>
      <xs:element name="inout_port" type="port"/>
      <xs:element name="description" type="xs:string"/>
      <xs:element name="MetadataFields">
        <xs:complexType>
          <xs:sequence>
            <xs:element name="Metadata" minOccurs="0" maxOccurs="unbounded">
              <xs:complexType><xs:anyAttribute processContents="skip"/></xs:complexType>
            </xs:element>
          </xs:sequence>
        </xs:complexType>
      </xs:element>
    </xs:choice>
    <xs:attribute name="ID" type="xs:string" use="required"/>
    <xs:attribute name="editable" type="xs:string"/>
  </xs:complexType>
  <xs:element name="root">
    <xs:complexType>
      <xs:choice minOccurs="0" maxOccurs="unbounded">
        <xs:element name="include">
          <xs:complexType>
            <xs:attribute name="path" type="xs:string" use="required"/>
            <xs:attribute name="ros_pkg" type="xs:string"/>
          </xs:complexType>
        </xs:element>
        <xs:element name="BehaviorTree">
          <xs:complexType>
            <xs:group ref="node"/>
            <xs:attribute name="ID" type="xs:string"/>
            <xs:anyAttribute processContents="skip"/>
          </xs:complexType>
        </xs:element>
        <xs:element name="TreeNodesModel">
          <xs:complexType>
            <xs:choice minOccurs="0" maxOccurs="unbounded">
              <xs:element name="Action" type="nodeModel"/>
              <xs:element name="Condition" type="nodeModel"/>
              <xs:element name="Control" type="nodeModel"/>
              <xs:element name="Decorator" type="nodeModel"/>
              <xs:element name="SubTree" type="nodeModel"/>
            </xs:choice>
          </xs:complexType>
        </xs:element>
      </xs:choice>
      <xs:attribute name="BTCPP_format" type="xs:string"/>
      <xs:attribute name="main_tree_to_execute" type="xs:string"/>
      <xs:anyAttribute processContents="skip"/>
    </xs:complexType>
  </xs:element>
"""

_EXPLICIT: Final = """  <xs:complexType name="explicit">
    <xs:group ref="node" minOccurs="0" maxOccurs="unbounded"/>
    <xs:attribute name="ID" type="xs:string" use="required"/>
    <xs:anyAttribute processContents="skip"/>
  </xs:complexType>
"""


def tree_schema(registry: BehaviourRegistry) -> str:
    """Make an XML schema (XSD 1.0) of documents with the registered behaviours."""
    names = registry.names()
    lines = [_HEAD.rstrip("\n"), '  <xs:group name="node">', "    <xs:choice>"]
    for tag in ("Action", "Condition", "Control", "Decorator"):
        lines.append(f'      <xs:element name="{tag}" type="explicit"/>')
    lines += [f'      <xs:element name="{name}" type="{name}.node"/>' for name in names]
    lines += ["    </xs:choice>", "  </xs:group>", _EXPLICIT.rstrip("\n")]
    for name in names:
        lines += _node_type(name, registry.get(name))
    lines.append("</xs:schema>")
    return "\n".join(lines) + "\n"


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
