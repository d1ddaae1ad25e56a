"""IfThenElse and WhileDoElse: a condition chooses the branch."""

from typing import ClassVar

from bt_manip.bt.nodes.parent import Control
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SUCCESS, NodeStatus
from bt_manip.exceptions import TreeError


class _Branching(Control):
    least_children: ClassVar = 2
    most_children: ClassVar = 3

    def _check_children(self) -> None:
        if len(self.children) not in (2, 3):
            raise TreeError(f"must have 2 or 3 children, not {len(self.children)}")


class IfThenElse(_Branching):
    """Ask the first child once, then tick the second one or the third one.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | of the condition: the second child is ticked; of a branch: SUCCESS  |
    | FAILURE | of the condition: the third child is ticked, or FAILURE if there is |
    |         | none; of a branch: FAILURE                                          |
    | RUNNING | RUNNING; while a branch runs, the condition is not asked again      |
    | SKIPPED | of the condition: an error; of a branch: SKIPPED                    |
    | halt    | the running child is halted; the condition is asked again           |
    """

    memory: ClassVar = ("_branch",)
    _branch = 0

    def _tick(self) -> NodeStatus:
        self._check_children()
        children = self.child_nodes
        self._enter()
        if self._branch == 0:
            state = children[0].execute()
            if state is RUNNING:
                return RUNNING
            if state is SUCCESS:
                self._branch = 1
            elif state is FAILURE:
                if len(children) == 2:
                    return FAILURE
                self._branch = 2
            else:
                raise TreeError("the condition was skipped: neither branch can be chosen")
        state = children[self._branch].execute()
        if state is RUNNING:
            return RUNNING
        self._reset_children()
        self._branch = 0
        return state

    def _halt(self) -> None:
        self._branch = 0
        super()._halt()


class WhileDoElse(_Branching):
    """Ask the first child at every tick; tick the second one, or else the third one.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | of the condition: the third child is halted, the second one ticked; |
    |         | of a branch: all are reset, SUCCESS                                 |
    | FAILURE | of the condition: the second child is halted and the third one      |
    |         | ticked, or FAILURE if there is none; of a branch: FAILURE           |
    | RUNNING | RUNNING                                                             |
    | SKIPPED | of the condition: an error; of a branch: SKIPPED                    |
    | halt    | the running children are halted                                     |
    """

    def _tick(self) -> NodeStatus:
        self._check_children()
        children = self.child_nodes
        self._enter()
        state = children[0].execute()
        if state is RUNNING:
            return RUNNING
        result = IDLE
        if state is SUCCESS:
            if len(children) == 3:
                self._halt_child(2)
            result = children[1].execute()
        elif state is FAILURE:
            result = FAILURE
            if len(children) == 3:
                self._halt_child(1)
                result = children[2].execute()
        if result is RUNNING:
            return RUNNING
        self._reset_children()
        if result is IDLE:
            raise TreeError("the condition was skipped: neither branch can be chosen")
        return result
