"""TryCatch: a sequence with a clean-up."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Control
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SKIPPED, SUCCESS, NodeStatus
from bt_manip.exceptions import PortError, TreeError


class TryCatch(Control):
    """Tick all children but the last as a Sequence; if one fails, tick the last one.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | the next one is ticked; SUCCESS after the last but one              |
    | FAILURE | all are reset, and the last child is ticked until it completes;     |
    |         | then FAILURE, whatever its result                                   |
    | RUNNING | RUNNING                                                             |
    | SKIPPED | as SUCCESS; SKIPPED if all but the last were skipped                |
    | halt    | all are halted; with catch_on_halt, and if the last child was not   |
    |         | being ticked yet, it is ticked once before                          |
    """

    least_children: ClassVar = 2
    memory: ClassVar = ("_index", "_skipped", "_catching", "_reason")
    catch_on_halt = Input(
        bool, default=False, doc="tick the last child also when the others are halted"
    )
    _index = 0
    _skipped = 0
    _catching = False
    _reason = ""

    def _tick(self) -> NodeStatus:
        children = self.child_nodes
        if len(children) < 2:
            raise TreeError("TryCatch must have at least 2 children")
        if self._node_status is not RUNNING:
            if self._node_status is IDLE:
                self._skipped = 0
                self._catching = False
            self._enter()
        if self._catching:
            return self._tick_catch()
        tried = len(children) - 1
        while self._index < tried:
            state = children[self._index].execute()
            if state is RUNNING:
                return RUNNING
            if state is FAILURE:
                if self._node_runtime is not None:
                    self._reason = self._node_runtime.reason
                self._reset_children()
                self._index = 0
                self._catching = True
                return self._tick_catch()
            self._index += 1
            if state is SKIPPED:
                self._skipped += 1
        all_skipped = self._skipped == tried
        self._reset_children()
        self._index = 0
        self._skipped = 0
        return SKIPPED if all_skipped else SUCCESS

    def _tick_catch(self) -> NodeStatus:
        if self.child_nodes[-1].execute() is RUNNING:
            return RUNNING
        self._reset_children()
        self._index = 0
        self._catching = False
        if self._node_runtime is not None and self._reason:
            self._node_runtime.reason = self._reason
        return FAILURE

    def _halt(self) -> None:
        if self._node_status is not IDLE and not self._catching and len(self.children) >= 2:
            if self._wants_catch():
                last = len(self.child_nodes) - 1
                for index in range(last):
                    self._halt_child(index)
                if self.child_nodes[last].execute() is RUNNING:
                    self._halt_child(last)
        self._index = 0
        self._skipped = 0
        self._catching = False
        super()._halt()

    def _wants_catch(self) -> bool:
        try:
            return bool(self.catch_on_halt)
        except PortError:
            return False
