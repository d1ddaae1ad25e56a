"""How a tree of the corpus is run: the options in its ``conformance`` comment."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.literals import parse_boolean, parse_status
from bt_manip.bt.nodes.test_node import TestNodeConfig
from bt_manip.bt.port_types import BOOL, DOUBLE, INT, STRING
from bt_manip.bt.substitution import Rule

_COMMENT = re.compile(r"<!--\s*conformance:(.*?)-->", re.DOTALL)
_STATUS_WORDS = {
    "success": "success_script",
    "failure": "failure_script",
    "post": "post_script",
    "status_script": "return_status_script",
}


@dataclass
class Options:
    """The options of one run.

    Attributes:
        ticks: At most so many ticks.
        stop_on_completion: Whether to stop at the first result that is not RUNNING.
        once: Whether a tick goes on while the tree is woken up.
        halt_before: The tick before which the tree is halted, or 0.
        sleep: How much time passes between two ticks [s].
        presets: Entries of the root's blackboard: type, key, value.
        substitutions: Rules for nodes to be replaced.
    """

    ticks: int = 20
    stop_on_completion: bool = True
    once: bool = False
    halt_before: int = 0
    sleep: float = 0.0
    presets: list[tuple[str, str, str]] = field(default_factory=list)
    substitutions: dict[str, Rule] = field(default_factory=dict)

    def blackboard(self) -> Blackboard:
        scope = Blackboard()
        for kind, key, text in self.presets:
            if kind == "int":
                scope.write(key, int(text), INT)
            elif kind == "double":
                scope.write(key, float(text), DOUBLE)
            elif kind == "bool":
                scope.write(key, parse_boolean(text), BOOL)
            else:
                scope.write(key, text, STRING)
        return scope


def options_in(text: str) -> dict[str, str]:
    found = _COMMENT.search(text)
    if found is None:
        return {}
    pairs = (pair.partition("=") for pair in found[1].split(";"))
    return {key.strip(): value.strip() for key, _, value in pairs if key.strip()}


def parse_options(raw: Mapping[str, str]) -> Options:
    options = Options(
        ticks=int(raw.get("ticks", 20)),
        stop_on_completion=raw.get("stop", "completion") != "never",
        once=raw.get("mode", "exactly_once") == "once",
        halt_before=int(raw.get("halt_before", 0)),
        sleep=int(raw.get("sleep_ms", 0)) / 1000,
    )
    for key, value in raw.items():
        first, _, rest = key.partition(".")
        if first == "bb":
            kind, _, name = rest.partition(".")
            options.presets.append((kind, name, value))
        elif first == "subst":
            options.substitutions[rest] = _rule(value)
    return options


def _rule(text: str) -> Rule:
    if ":" not in text:
        return text
    fields: dict[str, object] = {}
    for part in text.split(","):
        key, _, value = part.partition(":")
        key = key.strip()
        if key == "status":
            fields["return_status"] = parse_status(value.strip())
        elif key == "delay":
            fields["async_delay"] = int(value)
        else:
            fields[_STATUS_WORDS[key]] = value
    return TestNodeConfig(**fields)  # type: ignore[arg-type]
