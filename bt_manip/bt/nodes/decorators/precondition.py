"""Precondition: the child only if a script is true."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.nodes.scripted import ScriptPort
from bt_manip.bt.port_types import STATUS
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, SUCCESS, NodeStatus


class Precondition(ScriptPort, Decorator):
    """Tick the child once a script was true, and then until the child has completed.

    | child   | what happens                                                       |
    |---------|--------------------------------------------------------------------|
    | not yet | while the script is false: the status of the port else             |
    | SUCCESS | SUCCESS; the next round asks the script again                      |
    | FAILURE | FAILURE; the next round asks the script again                      |
    | RUNNING | RUNNING; the script is not asked again                             |
    | SKIPPED | SKIPPED; the script is not asked again                             |
    | halt    | the child is halted; the script is not asked again                 |
    """

    memory: ClassVar = ("_passed",)
    script_port = "if"
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
        state = self.link.execute()
        if state is SUCCESS or state is FAILURE:
            self._reset_child()
            self._passed = False
        return state
