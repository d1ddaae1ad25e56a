"""Decorators that change the child's result: Inverter, ForceSuccess, ForceFailure, ..."""

from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.status import FAILURE, RUNNING, SUCCESS, NodeStatus


class Inverter(Decorator):
    """Turn success into failure and failure into success.

    | child   | what happens        |
    |---------|---------------------|
    | SUCCESS | FAILURE             |
    | FAILURE | SUCCESS             |
    | RUNNING | RUNNING             |
    | SKIPPED | SKIPPED             |
    | halt    | the child is halted |
    """

    def _tick(self) -> NodeStatus:
        self._enter()
        state = self.link.execute()
        if state is SUCCESS:
            self._because(f"{self.link.name} succeeded")
            self._reset_child()
            return FAILURE
        if state is FAILURE:
            self._reset_child()
            return SUCCESS
        return state


class ForceSuccess(Decorator):
    """Succeed when the child has completed, whatever its result.

    | child   | what happens        |
    |---------|---------------------|
    | SUCCESS | SUCCESS             |
    | FAILURE | SUCCESS             |
    | RUNNING | RUNNING             |
    | SKIPPED | SKIPPED             |
    | halt    | the child is halted |
    """

    def _tick(self) -> NodeStatus:
        self._enter()
        state = self.link.execute()
        if state is SUCCESS or state is FAILURE:
            self._reset_child()
            return SUCCESS
        return state


class ForceFailure(Decorator):
    """Fail when the child has completed, whatever its result.

    | child   | what happens        |
    |---------|---------------------|
    | SUCCESS | FAILURE             |
    | FAILURE | FAILURE             |
    | RUNNING | RUNNING             |
    | SKIPPED | SKIPPED             |
    | halt    | the child is halted |
    """

    def _tick(self) -> NodeStatus:
        self._enter()
        state = self.link.execute()
        if state is SUCCESS or state is FAILURE:
            if state is SUCCESS:
                self._because(f"{self.link.name} succeeded, but failure is forced")
            self._reset_child()
            return FAILURE
        return state


class KeepRunningUntilFailure(Decorator):
    """Tick the child again and again until it fails.

    | child   | what happens                         |
    |---------|--------------------------------------|
    | SUCCESS | RUNNING; the next tick starts it anew |
    | FAILURE | FAILURE                              |
    | RUNNING | RUNNING                              |
    | SKIPPED | RUNNING                              |
    | halt    | the child is halted                  |
    """

    def _tick(self) -> NodeStatus:
        self._enter()
        state = self.link.execute()
        if state is FAILURE:
            self._reset_child()
            return FAILURE
        if state is SUCCESS:
            self._reset_child()
        return RUNNING
