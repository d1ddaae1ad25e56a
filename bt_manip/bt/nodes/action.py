"""Leaves that act, and that may take more than one tick."""

import copy
from collections.abc import Sequence
from typing import Any, ClassVar, Final, Self

from bt_manip.bt.nodes.node import Node, NodeKind
from bt_manip.bt.status import (
    FAILURE,
    IDLE,
    PY_STATUS,
    RUNNING,
    SKIPPED,
    SUCCESS,
    NodeStatus,
    Status,
    node_status,
)
from bt_manip.bt.traits import Traits
from bt_manip.exceptions import TreeError, with_short_values

_RUNNING: Final = Status.RUNNING
_SUCCESS: Final = Status.SUCCESS
_FAILURE: Final = Status.FAILURE
_INVALID: Final = Status.INVALID
STILL_RUNNING: Final = "a condition returned RUNNING: work that takes time belongs in an Action"


class Leaf(Node):
    """A node without children, written as a py_trees behaviour.

    ``initialise`` starts the work, ``update`` checks it once per tick, and ``terminate`` ends it:
    with ``SUCCESS`` or ``FAILURE`` when it has completed, with ``INVALID`` when it is halted.

    Attributes:
        traits: What it can answer, commands, needs and leaves, for checks before the run; None if
            it may do anything.
    """

    traits: ClassVar[Traits | None] = None

    _node_ended = False
    _node_starts: ClassVar[bool] = False
    _node_ends: ClassVar[bool] = False

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Note which hooks the class has: calling empty ones would take half of a tick's time."""
        super().__init_subclass__(**kwargs)
        cls._node_starts = cls.initialise is not Leaf.initialise
        cls._node_ends = cls.terminate is not Leaf.terminate

    def initialise(self) -> None:
        """Start the work; called when the node is ticked and was not running."""

    def update(self) -> Status | NodeStatus:  # type: ignore[override]
        """Check the work, once per tick.

        Returns:
            ``RUNNING``, ``SUCCESS`` or ``FAILURE``; or ``NodeStatus.SKIPPED``.
        """
        raise TreeError(f"{type(self).__name__} needs an update()")

    def terminate(self, new_status: Status) -> None:
        """End the work, completed or halted."""

    def fail(self, reason: str) -> Status:
        """Fail with a reason, from ``initialise`` or ``update``.

        Args:
            reason: Why; it becomes the node's ``feedback_message``.

        Returns:
            ``FAILURE``, so that ``update`` can ``return self.fail("...")``.
        """
        self.feedback_message = with_short_values(str(reason))  # it may be an exception
        self._node_ended = True
        return _FAILURE

    def _start(self) -> NodeStatus:
        self.feedback_message = ""
        if self._node_starts:
            self._node_ended = False
            self.initialise()
            if self._node_ended:
                return self._finish(_FAILURE)
        result = self.update()
        if result is _SUCCESS and not self._node_ends:
            return SUCCESS
        return self._finish(result)

    def _halt(self) -> None:
        if self._node_status is RUNNING:
            self.terminate(_INVALID)
        self._reset()

    def _finish(self, result: Status | NodeStatus) -> NodeStatus:
        state = RUNNING if result is _RUNNING else node_status(result)  # in most ticks
        if state is RUNNING:
            return RUNNING
        if state is IDLE:
            raise TreeError("update() must not return INVALID")
        if state is FAILURE and self._node_runtime is not None:
            self._node_runtime.failed(self.path or self.name, self.feedback_message)
        if state is not SKIPPED or self._node_status is not RUNNING:
            self.terminate(PY_STATUS[state])
        return state


class Action(Leaf):
    """A leaf that acts: it may run over many ticks, and it can be halted.

    A completed action that is ticked again before its parent has reset it gives the same status
    again and does nothing, as the engine's stateful actions do.
    """

    kind: ClassVar = NodeKind.ACTION

    def _tick(self) -> NodeStatus:
        status = self._node_status
        if status is IDLE:
            return self._start()
        if status is RUNNING:
            return self._finish(self.update())
        return status


class SyncAction(Action):
    """An action that completes within its tick, and that does its work again at every tick."""

    def _tick(self) -> NodeStatus:
        state = self._start()
        if state is RUNNING:
            raise TreeError("a synchronous action must not return RUNNING")
        return state


class Condition(Leaf):
    """A leaf that checks a state: it is evaluated again at every tick.

    It should say SUCCESS or FAILURE at once. The engine only asks for that in its documentation:
    RUNNING is passed on and the condition is ticked again, and so it is here; but its feedback
    message warns, and the contract of conditions fails.
    """

    kind: ClassVar = NodeKind.CONDITION

    goal_conditions: "Sequence[Condition]" = ()
    """Conditions in place of it in a goal, such as one for each object."""

    def with_port(self, port: str, text: str) -> Self:
        """Return a copy with another text of a port, in the same scope."""
        copied = type(self)(self.name, **{**self.given, port: text})
        copied.registration, copied.path = self.registration, self.path
        copied._node_runtime, copied._node_scope = self._node_runtime, self._node_scope
        return copied

    def begin_cycle(self) -> None:
        """Forget what was observed before; called for conditions of a goal before each cycle.

        By default, attributes in `memory` return to the values that the class declares.
        """
        for name in self.memory:
            if hasattr(type(self), name):
                setattr(self, name, copy.deepcopy(getattr(type(self), name)))

    def _tick(self) -> NodeStatus:
        state = self._finish(self.update()) if self._node_status is RUNNING else self._start()
        if state is RUNNING and not self.feedback_message:
            self.feedback_message = STILL_RUNNING
        return state
