"""The leaves that the trees of the conformance corpus use."""

from contextlib import suppress
from enum import Enum
from typing import Any, ClassVar

from bt_manip.bt.nodes.action import Action, Condition, SyncAction
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.port_types import PortType
from bt_manip.bt.ports import InOut, Input, Output
from bt_manip.bt.registry import BehaviourRegistry
from bt_manip.bt.status import IDLE, RUNNING, NodeStatus, Status
from bt_manip.exceptions import PortError

Event = dict[str, Any]

_OUTCOMES = {
    "S": NodeStatus.SUCCESS,
    "F": NodeStatus.FAILURE,
    "R": NodeStatus.RUNNING,
    "K": NodeStatus.SKIPPED,
    "I": NodeStatus.IDLE,
}


class Color(Enum):
    """The enumeration of the corpus."""

    RED = 1
    GREEN = 2
    BLUE = 3

    @classmethod
    def _missing_(cls, value: Any) -> "Color":
        """Take any other number, as an enumeration of C++ does."""
        other = object.__new__(cls)
        other._name_, other._value_ = str(value), value
        return other


class Logging(Node):
    """A node that writes down what happens to it."""

    log: ClassVar[list[Event]]

    def _event(self, kind: str, **data: Any) -> None:
        self.log.append({"node": self.name, "ev": kind, **data})

    def _read(self, port: str) -> tuple[Any, str]:
        """Return the value of a port, or None and why it cannot be read."""
        try:
            return self.read_port(port), ""
        except PortError as error:
            return None, str(error)


class _Cursor(Logging):
    outcomes = Input(str, default="S", doc="comma separated S,F,R,K(skipped),I(idle),X(throw)")
    mode = Input(str, default="hold", doc="hold|cycle")
    _cursor = 0

    def _outcome(self, event: str) -> NodeStatus:
        letters = [letter.strip() for letter in self.outcomes.split(",")]
        if self.mode == "cycle":
            letter = letters[self._cursor % len(letters)]
        else:
            letter = letters[min(self._cursor, len(letters) - 1)]
        self._cursor += 1
        self._event(event, outcome=letter)
        if letter == "X":
            raise RuntimeError("scripted exception")
        return _OUTCOMES[letter[:1]]


class _Scripted(_Cursor, Action):
    """Walk a list of outcomes; a stateful action."""

    on_halt = Input(str, default="keep", doc="keep|reset")

    def update(self) -> NodeStatus:  # type: ignore[override]
        return self._outcome("running" if self._node_status is RUNNING else "start")

    def terminate(self, new_status: Status) -> None:
        if new_status is Status.INVALID and self._node_status is RUNNING:
            self._event("halt")
            if self.on_halt == "reset":
                self._cursor = 0


class _SyncScripted(_Cursor, SyncAction):
    """Walk a list of outcomes; a synchronous action."""

    def update(self) -> NodeStatus:  # type: ignore[override]
        return self._outcome("tick")


class _ScriptedCondition(_Cursor, Condition):
    """Walk a list of outcomes; a condition."""

    def _tick(self) -> NodeStatus:
        return self._outcome("tick")


class _SetOut(Logging, SyncAction):
    """Write a value to an output."""

    def update(self) -> Status:
        value, problem = self._read("value")
        if problem:
            self._event("tick", input_error=problem)
            return Status.FAILURE
        try:
            self.write_port("out", value)
        except PortError as error:
            self._event("tick", output_error=str(error))
            return Status.FAILURE
        self._event("tick", wrote=_plain(value))
        return Status.SUCCESS


class _CheckIn(Logging, SyncAction):
    """Compare an input with what is expected."""

    def update(self) -> Status:
        value, problem = self._read("in")
        if problem:
            self._event("tick", input_error=problem)
            return Status.FAILURE
        if "expected" not in self.given:
            self._event("tick", read=_plain(value))
            return Status.SUCCESS
        expected, problem = self._read("expected")
        about = {} if problem else {"expected": _plain(expected)}
        self._event("tick", read=_plain(value), **about)
        return Status.SUCCESS if not problem and value == expected else Status.FAILURE


class _WithDefaults(Logging, SyncAction):
    """Read ports with all kinds of defaults."""

    a = Input(int, default=7, doc="literal default")
    b = Input(int, default="{seven}", doc="blackboard default")
    c = Input(int, doc="no default")
    same = Input(int, default="{=}", doc="same-name default")
    out = Output(int, default="{result}", doc="output default")
    io = InOut(int, doc="inout")

    def update(self) -> Status:
        values = {name: self._read(name)[0] for name in ("a", "b", "c", "same", "io")}
        self._event("tick", **values)
        for name, value in (("out", 99), ("io", values["io"])):
            if value is not None:
                with suppress(PortError):
                    self.write_port(name, value + (name == "io"))
        return Status.SUCCESS


class _Log(Logging, SyncAction):
    """Write a message down."""

    msg = Input(str, default="")

    def update(self) -> Status:
        self._event("tick", msg=self._read("msg")[0] or "")
        return Status.SUCCESS


class _PassThrough(Logging, Decorator):
    """Hand the child's status on, and write it down."""

    def _tick(self) -> NodeStatus:
        if self._node_status is IDLE:
            self._enter()
        state = self.child_node.execute()
        self._event("decorated", child=state.name)
        return state

    def _halt(self) -> None:
        self._event("halt")
        super()._halt()


def _plain(value: Any) -> Any:
    return value.value if isinstance(value, Enum) else value


_TYPES: dict[str, Any] = {
    "Int": int,
    "Double": float,
    "String": str,
    "Bool": bool,
    "VecInt": list[int],
    "VecDouble": list[float],
}


def corpus_registry(log: list[Event]) -> BehaviourRegistry:
    """Give a registry with the leaves of the corpus.

    Args:
        log: Takes what happens to them, in order.
    """
    registry = BehaviourRegistry()
    registry.register_enum(Color)
    bases: dict[str, type[Node]] = {
        "Scripted": _Scripted,
        "SyncScripted": _SyncScripted,
        "ScriptedCondition": _ScriptedCondition,
        "WithDefaults": _WithDefaults,
        "Log": _Log,
        "PassThrough": _PassThrough,
    }
    for name, base in bases.items():
        registry.register(type(name, (base,), {"log": log, "__doc__": base.__doc__}))
    for name, python in _TYPES.items():
        body = {"log": log, "value": Input(python), "out": Output(python)}
        registry.register(type(f"SetOut{name}", (_SetOut,), body))
        if name != "VecInt":
            body = {"log": log, "in_": Input(python), "expected": Input(python)}
            registry.register(type(f"CheckIn{name}", (_CheckIn,), body))
    colour = PortType("Color", Color, parse=_no_colour, format=lambda color: color.name)
    registry.register(type("CheckInColor", (_CheckIn,), {"log": log, "in_": Input(colour)}))
    return registry


def _no_colour(text: str) -> Color:
    raise ValueError(f"'{text}' is no colour")
