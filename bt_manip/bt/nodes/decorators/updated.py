"""SkipUnlessUpdated and WaitValueUpdate: the child only when an entry was written."""

from typing import Any, ClassVar

from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.nodes.watching import Watching
from bt_manip.bt.port_types import ANY
from bt_manip.bt.ports import Input
from bt_manip.bt.status import RUNNING, SKIPPED, NodeStatus


class _Updated(Watching, Decorator):
    memory: ClassVar = ("_seen", "_child_running")
    _otherwise: ClassVar[NodeStatus]
    entry = Input(ANY, doc="the entry that is watched")
    _child_running = False

    def _tick(self) -> NodeStatus:
        if not self._child_running and not self._was_updated():
            return self._otherwise
        self._child_running = False
        state: Any = self.link.execute()
        self._child_running = state is RUNNING
        return state

    def _halt(self) -> None:
        self._child_running = False
        super()._halt()


class SkipUnlessUpdated(_Updated):
    """Tick the child if an entry was written since the last look, else skip.

    | child       | what happens                                                 |
    |-------------|--------------------------------------------------------------|
    | not written | SKIPPED; a missing entry was not written                     |
    | SUCCESS     | SUCCESS                                                      |
    | FAILURE     | FAILURE                                                      |
    | RUNNING     | RUNNING; the next tick goes on with it without another look  |
    | SKIPPED     | SKIPPED                                                      |
    | halt        | the child is halted                                          |
    """

    _otherwise: ClassVar = SKIPPED


class WaitValueUpdate(_Updated):
    """Tick the child if an entry was written since the last look, else wait.

    | child       | what happens                                                 |
    |-------------|--------------------------------------------------------------|
    | not written | RUNNING; a missing entry was not written                     |
    | SUCCESS     | SUCCESS                                                      |
    | FAILURE     | FAILURE                                                      |
    | RUNNING     | RUNNING; the next tick goes on with it without another look  |
    | SKIPPED     | SKIPPED                                                      |
    | halt        | the child is halted                                          |
    """

    _otherwise: ClassVar = RUNNING
