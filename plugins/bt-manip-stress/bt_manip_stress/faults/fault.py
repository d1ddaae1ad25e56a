"""The base class of faults, and the context of a fault."""

import abc
import math
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bt_manip.bt import Tree
from bt_manip.cell import Cell, CellError, as_object
from bt_manip.exceptions import BtManipError
from bt_manip.parameters import Parameter
from bt_manip.runner import CommandedRobot, Station


class FaultError(BtManipError):
    """The description of a fault is invalid, or it cannot occur in the present state."""


def parameter(default: Any, meaning: str, **declared: Any) -> Any:
    """Declare a parameter of a fault, a field of its dataclass.

    Args:
        default: Its default, a number or a text, which determines its type.
        meaning: Its meaning, with the unit in brackets.
        **declared: Other fields of `bt_manip.parameters.Parameter`, such as ``at_most``; a number
            is at least 0 by default.
    """
    bounds = {} if isinstance(default, str) else {"at_least": 0.0}
    known = Parameter(meaning, default=default, **{**bounds, **declared})
    return field(default=default, metadata={"parameter": known})


@dataclass(frozen=True)
class FaultContext:
    """The run in which a fault occurs.

    Attributes:
        station: The station.
        tree: The running tree.
        node: The node at whose start the fault begins.
        rng: Random generator of the fault.
    """

    station: Station
    tree: Tree
    node: Any
    rng: np.random.Generator

    @property
    def cell(self) -> Cell:
        """The cell."""
        return self.station.cell

    @property
    def robot(self) -> CommandedRobot:
        """The robot of the node, or the first one."""
        name = getattr(self.node, "robot_name", "")
        return self.station.robots.get(name) or self.station.first

    def find_object(self, name: str = "") -> str:
        """Return an object by name; by default the object that the tree handles.

        This is the object of the node's port ``object``, the held object, or the object added last.

        Raises:
            FaultError: If there is none.
        """
        gripper = self.robot.gripper
        held = () if gripper is None else gripper.held
        free = [one for one in reversed(list(self.cell.objects)) if self.cell.is_free(one)]
        return self._first("object", name, [self._port("object"), *held, *free])

    def find_container(self, name: str = "") -> str:
        """Return a container by name; by default that of the node's port, or the first one.

        Raises:
            FaultError: If there is none.
        """
        objects = self.cell.objects.items()
        containers = [one for one, entity in objects if as_object(entity).category == "container"]
        return self._first("container", name, [self._port("container"), *containers])

    def _port(self, port: str) -> str:
        with suppress(Exception):  # no such port, an output, or an entry that was never written
            return str(self.node.read_port(port))
        return ""

    def _first(self, what: str, name: str, choices: list[str]) -> str:
        for choice in [name] if name else choices:
            if choice in self.cell.entities:
                return choice
        raise FaultError(f"there is no {what} {name!r}" if name else f"there is no {what}")


@dataclass
class Fault(abc.ABC):
    """A disturbance of the cell, the robot or the tree, for a duration or until its cycle ends.

    A subclass is a dataclass with fields declared by `parameter`, and implements ``begin``. Changes
    made by ``begin`` have to be undone at the end of the fault: by `override`, `at_end`, or
    ``end``. It is registered by the hook ``register_faults``. ``bt-manip list faults`` shows the
    first line of its docstring.

    Attributes:
        context: The run in which it occurs, from `start` on.
    """

    duration: float = parameter(
        math.inf, "Time after which it ends [s]; inf: with its cycle.", infinite=True
    )

    def start(self, context: FaultContext) -> None:
        """Begin, between two ticks.

        Raises:
            FaultError: If it cannot occur in the present state; nothing is changed.
        """
        self.context = context
        self._undo = ExitStack()
        try:
            self.begin()
            self.bind()
        except BaseException as error:
            self.end()
            if isinstance(error, CellError):
                raise FaultError(str(error)) from error
            raise

    @abc.abstractmethod
    def begin(self) -> None:
        """Apply the fault.

        Raises:
            FaultError: If it cannot occur in the present state.
        """

    def bind(self) -> None:  # noqa: B027
        """Update data of the compiled model; called after ``begin`` and each compile."""

    def end(self) -> None:
        """Undo the fault."""
        self._undo.close()

    def at_end(self, undo: Callable[..., object], *arguments: Any, **named: Any) -> None:
        """Call a function at the end of the fault; the last one is called first."""
        self._undo.callback(undo, *arguments, **named)

    def override(self, element: str, **values: Any) -> None:
        """Override physical properties, like `Cell.override`, until the fault ends."""
        cell = self.context.cell
        before = cell.overrides.get(element, {})
        cell.override(element, **values)

        def restore() -> None:
            with suppress(CellError):  # it was removed meanwhile
                cell.override(element, **{name: before.get(name) for name in values})

        self.at_end(restore)
