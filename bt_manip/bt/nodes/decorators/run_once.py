"""RunOnce: the child once in the life of the tree."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, IDLE, SKIPPED, SUCCESS, NodeStatus
from bt_manip.exceptions import PortError


class RunOnce(Decorator):
    """Tick the child until it has completed once; never again.

    | child     | what happens                                                   |
    |-----------|----------------------------------------------------------------|
    | SUCCESS   | SUCCESS                                                        |
    | FAILURE   | FAILURE                                                        |
    | RUNNING   | RUNNING                                                        |
    | SKIPPED   | SKIPPED; this does not count as its run                        |
    | completed | SKIPPED, or with then_skip=false the status it had             |
    | halt      | the child is halted; this does not count as its run            |
    """

    memory: ClassVar = ("_result",)
    then_skip = Input(
        bool,
        default=True,
        doc="skip afterwards; if false, return the status of that one run again",
    )
    _result = int(IDLE)

    def _tick(self) -> NodeStatus:
        try:
            then_skip = self.then_skip
        except PortError:
            then_skip = True
        if self._result:
            if not then_skip and self._result == FAILURE:
                self._because(f"{self.link.name} failed when it ran")
            return SKIPPED if then_skip else NodeStatus(self._result)
        self._enter()
        state = self.link.execute()
        if state is SUCCESS or state is FAILURE:
            self._result = int(state)
            self._reset_child()
        return state
