"""Leaf mappings: behaviours that replace the leaves and sub-trees of other projects."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from bt_manip.bt import (
    Blackboard,
    Document,
    Element,
    Problems,
    ScriptCondition,
    Tree,
    is_pointer,
    node_name,
    port_attributes,
)
from bt_manip.exceptions import BtManipError, ScriptError, TreeError, did_you_mean
from bt_manip.files import read_text
from bt_manip.toml import parse_toml

MAX_TOML_BYTES = 2**18
_KEYS = ("node", "when", "ports", "set")


@dataclass(frozen=True)
class MappingRule:
    """One rule of a mapping.

    Attributes:
        node: The behaviour that replaces the leaf.
        when: A script over the leaf's ports that has to be true; empty: always.
        ports: The leaf's ports by the names of the behaviour's.
        constants: Values of further ports.
    """

    node: str
    when: str
    ports: Mapping[str, str]
    constants: Mapping[str, str]


class LeafMapping:
    """Rules by the name of the leaf or sub-tree that they replace.

    Args:
        rules: The rules; the first rule of a name that holds is applied.
        file: The file name in messages.
    """

    def __init__(self, rules: Mapping[str, list[MappingRule]], file: str) -> None:
        self.rules = rules
        self._file = file

    @classmethod
    def read(cls, path: str | Path) -> "LeafMapping":
        """Read a mapping from a TOML file.

        A table, or an array of tables, for each name: ``node`` names the behaviour, ``when`` is a
        script over the leaf's ports, ``ports`` has the leaf's ports by the behaviour's, ``set``
        has constants.

        Raises:
            TreeError: If it cannot be read, or has another form.
        """
        try:
            data = parse_toml(read_text(path, MAX_TOML_BYTES))
        except OSError as error:
            raise TreeError(f"{path}: {error.strerror}") from None
        except ValueError as error:  # not UTF-8 or not TOML
            raise TreeError(f"{path}: {error}") from None
        rules = {}
        for name, tables in data.items():
            tables = tables if isinstance(tables, list) else [tables]
            rules[name] = [_rule(table, f"{path}: {name}") for table in tables]
        return cls(rules, str(path))

    def apply(self, document: Document, problems: Problems) -> None:
        """Replace the leaves and sub-trees of a document, each once.

        Args:
            document: The document, its libraries included.
            problems: Collects the leaves for which no rule holds.
        """
        for tree in document.top_level("BehaviorTree"):
            for element in [*tree.iterate()]:  # without those that replace others
                self._replace(element, problems)

    def _replace(self, element: Element, problems: Problems) -> None:
        name = (element.get("ID") or "") if element.name == "SubTree" else node_name(element)
        if name not in self.rules or element.children:
            return
        given = port_attributes(element)
        try:
            rules = self._choose(name, {key: a.value for key, a in given.items()})
        except BtManipError as error:
            problems.error(element.place, f"{self._file}: {name}: {error}")
            return
        kept = {
            key: a
            for key, a in element.attributes.items()
            if key not in given and key not in ("ID", "_autoremap")
        }
        made = [_made(rule, given, element) for _, rule in rules]
        # Where the rule depends on the blackboard, it is chosen when the node is ticked.
        branch = made[-1]
        for (condition, _), leaf in zip(reversed(rules[:-1]), reversed(made[:-1]), strict=True):
            test = Element("ScriptCondition", element.place)
            test.set("code", condition)
            branch = Element("IfThenElse", element.place, content=[test, leaf, branch])
        element.name, element.content = branch.name, branch.content or element.content
        element.attributes = {**branch.attributes, **kept}

    def _choose(self, name: str, given: Mapping[str, str]) -> list[tuple[str, MappingRule]]:
        """Return the rules that may hold, with their conditions over the blackboard."""
        scope = Blackboard()
        for key, text in given.items():
            if not is_pointer(text):
                scope.set_text(key, text)
        rules: list[tuple[str, MappingRule]] = []
        for rule in self.rules[name]:
            if not rule.when:
                return [*rules, ("", rule)]
            reads = _reads(rule.when)
            for key in reads - given.keys():
                raise TreeError(f"the rule '{rule.when}' needs the port '{key}'")
            pointers = {key: given[key].strip(" ")[1:-1] for key in reads if is_pointer(given[key])}
            if pointers:
                condition = rule.when
                for key, entry in pointers.items():
                    entry = key if entry == "=" else entry
                    condition = re.sub(rf"(?<![\w@.]){key}\b", entry, condition)
                rules.append((condition, rule))
            elif _condition(rule.when, scope).tick_exactly_once().name == "SUCCESS":
                return [*rules, ("", rule)]
        values = ", ".join(f"{key}={text}" for key, text in given.items())
        raise TreeError(f"no rule holds for {values or 'a leaf without ports'}")


def _condition(script: str, scope: Blackboard) -> Tree:
    return Tree(ScriptCondition(code=script), blackboard=scope)


def _reads(script: str) -> set[str]:
    """Return the names in a script."""
    plain = re.sub(r"'[^']*'|\"[^\"]*\"|\b0x[0-9A-Fa-f]+|\b[0-9.]+([eE][-+]?[0-9]+)?", " ", script)
    return {*re.findall(r"[A-Za-z_@]\w*", plain)} - {"true", "false"}


def _made(rule: MappingRule, given: Mapping[str, Any], element: Element) -> Element:
    made = Element(rule.node, element.place)
    for port, theirs in rule.ports.items():
        if theirs in given:
            a = given[theirs]
            value = f"{{{theirs}}}" if a.value == "{=}" else a.value
            made.attributes[port] = replace(a, name=port, value=value)
    for port, text in rule.constants.items():
        made.set(port, text)
    return made


def _rule(table: Any, where: str) -> MappingRule:
    if not isinstance(table, dict) or not isinstance(table.get("node"), str):
        raise TreeError(f"{where}: 'node' is missing: the name of a behaviour")
    for key in table:
        if key not in _KEYS:
            raise TreeError(f"{where}: '{key}' means nothing{did_you_mean(key, _KEYS)}")
    ports, constants = table.get("ports", {}), table.get("set", {})
    when = table.get("when", "")
    if not isinstance(ports, dict) or not all(isinstance(p, str) for p in ports.values()):
        raise TreeError(f"{where}: 'ports' is a table of names of ports")
    if not isinstance(constants, dict) or not isinstance(when, str):
        raise TreeError(f"{where}: 'set' is a table of values, 'when' a script")
    if when:
        try:
            _condition(when, Blackboard())
        except ScriptError as error:
            raise TreeError(f"{where}: when: {error}") from None
    return MappingRule(table["node"], when, ports, {k: _text(v) for k, v in constants.items()})


def _text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return ";".join(map(str, value)) if isinstance(value, list) else str(value)
