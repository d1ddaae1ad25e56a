"""Substitution rules: replacing nodes of a tree, for tests."""

import json
from collections.abc import Mapping
from dataclasses import fields
from fnmatch import fnmatchcase
from typing import Any

from bt_manip.bt.literals import parse_status
from bt_manip.bt.nodes.test_node import TestNodeConfig
from bt_manip.exceptions import TreeError

Rule = str | TestNodeConfig
"""The name of the node to use instead, or the configuration of a TestNode."""

Substitutions = Mapping[str, Rule]
"""Rules by the nodes that they replace: a name, a registered name, or a path (with ``* ?``)."""


def find_rule(rules: Substitutions, name: str, registration: str, path: str) -> Rule | None:
    """Find the first rule that applies to a node."""
    for pattern, rule in rules.items():
        if pattern in (name, registration) or matches(path, pattern):
            return rule
    return None


def matches(text: str, pattern: str) -> bool:
    """Return whether a text matches a pattern, ``*`` being any text and ``?`` any character."""
    return fnmatchcase(text, pattern.replace("[", "[[]"))


def substitutions_from_json(text: str) -> dict[str, Rule]:
    """Read rules from the engine's JSON form.

    Args:
        text: ``{"TestNodeConfigs": {NAME: {...}}, "SubstitutionRules": {PATTERN: NAME}}``.

    Raises:
        TreeError: If it has another form.
    """
    try:
        data = json.loads(text)
        configs = {
            name: _config(name, given) for name, given in data.get("TestNodeConfigs", {}).items()
        }
        rules = data["SubstitutionRules"]
        return {pattern: configs.get(name, str(name)) for pattern, name in rules.items()}
    except KeyError as error:
        raise TreeError(f"the substitution rules lack {error}") from None
    except (ValueError, AttributeError, TypeError) as error:
        raise TreeError(f"the substitution rules cannot be read: {error}") from None


def _config(name: str, given: Mapping[str, Any]) -> TestNodeConfig:
    names = {field.name for field in fields(TestNodeConfig)} - {"complete_func"}
    known = {key: value for key, value in given.items() if key in names}
    if "return_status" in known:
        known["return_status"] = parse_status(known["return_status"])
    elif not known.get("return_status_script"):
        raise TreeError(f"TestNodeConfig '{name}' needs return_status or return_status_script")
    return TestNodeConfig(**known)
