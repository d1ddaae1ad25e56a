"""ReactiveSequence and ReactiveFallback: all children from the first one, at every tick."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Control
from bt_manip.bt.status import FAILURE, RUNNING, SKIPPED, SUCCESS, NodeStatus


class _Reactive(Control):
    _goes_on: ClassVar = SUCCESS

    def _tick(self) -> NodeStatus:
        children = self._child_nodes or self.child_nodes
        self._enter()
        goes_on = self._goes_on
        all_skipped = True
        for index, child in enumerate(children):
            state = child.execute()
            if state is goes_on:
                all_skipped = False
            elif state is RUNNING:
                for other in range(len(children)):
                    if other != index:
                        self._halt_child(other)
                return RUNNING
            elif state is SKIPPED:
                self._halt_child(index)
            else:
                self._reset_children()
                return state
        self._reset_children()
        return SKIPPED if all_skipped else goes_on


class ReactiveSequence(_Reactive):
    """Tick all children from the first one at every tick; fail as soon as one fails.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | the next child is ticked; after the last one SUCCESS                |
    | FAILURE | all are reset, FAILURE                                              |
    | RUNNING | all others are halted, RUNNING                                      |
    | SKIPPED | it is reset and the next is ticked; SKIPPED if all were skipped     |
    | halt    | the running child is halted                                         |
    """


class ReactiveFallback(_Reactive):
    """Tick all children from the first one at every tick; succeed as soon as one succeeds.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | all are reset, SUCCESS                                              |
    | FAILURE | the next child is ticked; after the last one FAILURE                |
    | RUNNING | all others are halted, RUNNING                                      |
    | SKIPPED | it is reset and the next is ticked; SKIPPED if all were skipped     |
    | halt    | the running child is halted                                         |
    """

    _goes_on: ClassVar = FAILURE
