"""Decorators that tick their child only under a condition: a script, a written entry, once."""

from typing import Any, ClassVar

from bt_manip.bt.nodes.actions.blackboard import Watching
from bt_manip.bt.nodes.actions.script import ScriptPort
from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.port_types import ANY, STATUS
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus
from bt_manip.exceptions import PortError


class Precondition(ScriptPort, Decorator):
    """Tick the child once a script was true, and then until the child has completed.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | not yet | while the script is false: the status of the port else              |
    | ended   | SUCCESS or FAILURE as it is; the next round asks the script again   |
    | others  | RUNNING and SKIPPED as they are; the script is not asked again      |
    | halt    | the child is halted; the script is not asked again                  |
    """

    memory: ClassVar = ("_passed",)
    checked_port = "if"
    if_ = Input(str, doc="script that must be true")
    else_ = Input(STATUS, default=FAILURE, doc="status while the script is false")
    _passed = False

    def _tick(self) -> NodeStatus:
        script = self._script()
        otherwise: NodeStatus = self.else_
        if not self._passed:
            self._passed = self._is_true(script)
        if not self._passed:
            if otherwise is FAILURE:
                self._because(f"not: {self._source}")
            return otherwise
        state = self.child_node.execute()
        if state is SUCCESS or state is FAILURE:
            self._reset_child()
            self._passed = False
        return state


class RunOnce(Decorator):
    """Tick the child until it has completed once; never again.

    | child     | result                                                         |
    |-----------|----------------------------------------------------------------|
    | any       | SUCCESS, FAILURE, RUNNING and SKIPPED as they are              |
    | completed | SKIPPED, or with then_skip=false the status it had             |
    | halt      | the child is halted; like SKIPPED, that is no run              |
    """

    memory: ClassVar = ("_result",)
    then_skip = Input(
        bool, default=True, doc="skip afterwards; if false, return the status of that one run again"
    )
    _result = int(IDLE)

    def _tick(self) -> NodeStatus:
        try:
            then_skip = self.then_skip
        except PortError:
            then_skip = True
        if self._result:
            if not then_skip and self._result == FAILURE:
                self._because(f"{self.child_node.name} failed when it ran")
            return SKIPPED if then_skip else NodeStatus(self._result)
        self._enter()
        state = self.child_node.execute()
        if state is SUCCESS or state is FAILURE:
            self._result = int(state)
            self._reset_child()
        return state


class _Updated(Watching, Decorator):
    memory: ClassVar = ("_seen", "_child_running")
    _otherwise: ClassVar[NodeStatus]
    entry = Input(ANY, doc="the entry that is watched")
    _child_running = False

    def _tick(self) -> NodeStatus:
        if not self._child_running and not self._was_updated():
            return self._otherwise
        self._child_running = False
        state: Any = self.child_node.execute()
        self._child_running = state is RUNNING
        return state

    def _halt(self) -> None:
        self._child_running = False
        super()._halt()


class SkipUnlessUpdated(_Updated):
    """Tick the child if an entry was written since the last check, else skip.

    | child       | result                                                       |
    |-------------|--------------------------------------------------------------|
    | not written | SKIPPED; a missing entry was not written                     |
    | RUNNING     | RUNNING; the next tick goes on with it without a check       |
    | others      | SUCCESS, FAILURE and SKIPPED as they are                     |
    | halt        | the child is halted                                          |
    """

    _otherwise: ClassVar = SKIPPED


class WaitValueUpdate(_Updated):
    """Tick the child if an entry was written since the last check, else wait.

    | child       | result                                                       |
    |-------------|--------------------------------------------------------------|
    | not written | RUNNING; a missing entry was not written                     |
    | RUNNING     | RUNNING; the next tick goes on with it without a check       |
    | others      | SUCCESS, FAILURE and SKIPPED as they are                     |
    | halt        | the child is halted                                          |
    """

    _otherwise: ClassVar = RUNNING
