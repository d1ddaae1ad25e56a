"""Decorators that change the child's result: Inverter, ForceSuccess, ForceFailure, ..."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.status import FAILURE, RUNNING, SUCCESS, NodeStatus


class _Forcing(Decorator):
    _on_success: ClassVar[NodeStatus] = SUCCESS
    _on_failure: ClassVar[NodeStatus] = FAILURE
    _reason: ClassVar = "succeeded"

    def _tick(self) -> NodeStatus:
        self._enter()
        state = self.child_node.execute()
        if state is not SUCCESS and state is not FAILURE:
            return state
        result = self._on_success if state is SUCCESS else self._on_failure
        if state is SUCCESS and result is FAILURE:
            self._because(f"{self.child_node.name} {self._reason}")
        self._reset_child()
        return result


class Inverter(_Forcing):
    """Turn success into failure and failure into success.

    | child   | result                           |
    |---------|----------------------------------|
    | SUCCESS | FAILURE                          |
    | FAILURE | SUCCESS                          |
    | others  | RUNNING and SKIPPED as they are  |
    | halt    | the child is halted              |
    """

    _on_success = FAILURE
    _on_failure = SUCCESS


class ForceSuccess(_Forcing):
    """Succeed when the child has completed, whatever its result.

    | child   | result                                   |
    |---------|------------------------------------------|
    | FAILURE | SUCCESS                                  |
    | others  | SUCCESS, RUNNING and SKIPPED as they are |
    | halt    | the child is halted                      |
    """

    _on_failure = SUCCESS


class ForceFailure(_Forcing):
    """Fail when the child has completed, whatever its result.

    | child   | result                                   |
    |---------|------------------------------------------|
    | SUCCESS | FAILURE                                  |
    | others  | FAILURE, RUNNING and SKIPPED as they are |
    | halt    | the child is halted                      |
    """

    _on_success = FAILURE
    _reason = "succeeded, but failure is forced"


class KeepRunningUntilFailure(Decorator):
    """Tick the child again and again until it fails.

    | child   | result                               |
    |---------|--------------------------------------|
    | SUCCESS | RUNNING; the next tick starts it anew |
    | FAILURE | FAILURE                              |
    | RUNNING | RUNNING                              |
    | SKIPPED | RUNNING                              |
    | halt    | the child is halted                  |
    """

    def _tick(self) -> NodeStatus:
        self._enter()
        state = self.child_node.execute()
        if state is FAILURE:
            self._reset_child()
            return FAILURE
        if state is SUCCESS:
            self._reset_child()
        return RUNNING
