"""Planned faults and their text format."""

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from bt_manip.bt import Tree
from bt_manip.exceptions import did_you_mean
from bt_manip.parameters import Parameter, parameters_of, read_words
from bt_manip.registry import Registry

from .fault import Fault, FaultError

WHEN = {
    "at": Parameter("Node at whose start it begins: path, name or registered name.", "", ""),
    "after": Parameter("Time after the start of the node [s].", default=0.0, at_least=0.0),
    "cycle": Parameter("Cycle in which it happens, from 1; 0: all.", default=0, at_least=0),
}
"""Parameters of all planned faults."""


@dataclass(frozen=True)
class PlannedFault:
    """A fault to inject into a run.

    Attributes:
        name: Its registered name.
        at: Path, name or registered name of its node.
        after: Time of the fault after the start of the node [s].
        cycle: Number of the cycle, from 1; 0: all cycles.
        parameters: Parameters of the fault.
    """

    name: str
    at: str
    after: float = 0.0
    cycle: int = 0
    parameters: Mapping[str, Any] = field(default_factory=dict)

    def __str__(self) -> str:
        """Return its text, for `parse_fault`."""
        when = {"at": self.at, "after": self.after, "cycle": self.cycle, **self.parameters}
        shown = [f"{k}={shlex.quote(f'{v:g}' if isinstance(v, float) else str(v))}"
                 for k, v in when.items() if k == "at" or v]  # fmt: skip
        return " ".join([self.name, *shown])

    def make(self, faults: Registry[Callable[..., Any]]) -> Fault:
        """Return a new fault."""
        return faults.maker(self.name, "start", "end")(**self.parameters)

    def nodes(self, tree: Tree) -> tuple[Any, ...]:
        """Return the nodes at whose start it begins.

        Raises:
            FaultError: If the tree has no such node; the nearest names are suggested.
        """
        for attribute in ("path", "name", "registration"):
            found = tuple(node for node in tree.nodes if getattr(node, attribute) == self.at)
            if found:
                return found
        known = {text for node in tree.nodes for text in (node.name, node.registration)}
        raise FaultError(
            f"fault '{self.name}': the tree has no node '{self.at}'{did_you_mean(self.at, known)}"
        )


def parse_fault(text: str, faults: Registry[Callable[..., Any]]) -> PlannedFault:
    """Parse a fault such as ``push at=Lift force=100 duration=0.5``.

    Args:
        text: The fault's name, then ``at=NODE``, and optionally ``after=SECONDS``, ``cycle=NUMBER``
            and parameters of the fault.
        faults: The registered faults.

    Raises:
        UnknownPartError: If there is no such fault; the nearest names are suggested.
        FaultError: If a parameter is unknown, missing or impossible.
    """
    try:
        name, *words = shlex.split(text)
    except ValueError as error:
        found = f": {error}" if text.strip() else ""
        raise FaultError(f"a fault is NAME at=NODE KEY=VALUE ..., got '{text}'{found}") from None
    cls: Any = faults.get(name)
    known = {**WHEN, **parameters_of(cls)}
    known["duration"] = replace(known["duration"], infinite=True)  # until its cycle ends
    values = read_words(words, known, f"fault '{name}'", FaultError)
    if not values.get("at"):
        raise FaultError(f"fault '{name}' needs at=NODE, the node at whose start it begins")
    when = {key: values.pop(key) for key in WHEN if key in values}
    return PlannedFault(name, **when, parameters=values)
