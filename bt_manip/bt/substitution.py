"""Substitution rules: putting other nodes in the place of some, for tests."""

import json
import re
from collections.abc import Mapping
from typing import Any

from bt_manip.bt.literals import parse_status
from bt_manip.bt.nodes.test_node import TestNodeConfig
from bt_manip.exceptions import TreeError

Rule = str | TestNodeConfig
"""The name of the node to use instead, or what a TestNode shall do instead."""

Substitutions = Mapping[str, Rule]
"""Rules by what they apply to: a node's name, its registered name, or its path (with ``* ?``)."""


def find_rule(rules: Substitutions, name: str, registration: str, path: str) -> Rule | None:
    """Find the first rule that applies to a node."""
    for pattern, rule in rules.items():
        if pattern in (name, registration) or matches(path, pattern):
            return rule
    return None


def matches(text: str, pattern: str) -> bool:
    """Tell whether a text matches a pattern, ``*`` being any text and ``?`` any character."""
    pieces = re.split(r"([*?])", re.sub(r"\*+", "*", pattern))
    expression = "".join({"*": ".*", "?": "."}.get(piece, re.escape(piece)) for piece in pieces)
    return re.fullmatch(expression, text, re.DOTALL) is not None


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
            name: _config(name, fields) for name, fields in data.get("TestNodeConfigs", {}).items()
        }
        rules = data["SubstitutionRules"]
        return {pattern: configs.get(name, str(name)) for pattern, name in rules.items()}
    except KeyError as error:
        raise TreeError(f"the substitution rules lack {error}") from None
    except (ValueError, AttributeError, TypeError) as error:
        raise TreeError(f"the substitution rules cannot be read: {error}") from None


def _config(name: str, fields: Mapping[str, Any]) -> TestNodeConfig:
    known = {key: value for key, value in fields.items() if key in _FIELDS}
    if "return_status" in known:
        known["return_status"] = parse_status(known["return_status"])
    elif not known.get("return_status_script"):
        raise TreeError(f"TestNodeConfig '{name}' needs return_status or return_status_script")
    return TestNodeConfig(**known)


_FIELDS = (
    "return_status",
    "return_status_script",
    "async_delay",
    "success_script",
    "failure_script",
    "post_script",
)
