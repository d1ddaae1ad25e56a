"""Parallel and ParallelAll: all children in every tick."""

from typing import Any, ClassVar

from bt_manip.bt.nodes.parent import Control
from bt_manip.bt.ports import Input
from bt_manip.bt.status import FAILURE, RUNNING, SKIPPED, SUCCESS, NodeStatus
from bt_manip.exceptions import TreeError


def threshold(count: int, children: int) -> int:
    """Return the number that a threshold means; a negative one counts from all children, -1."""
    return max(children + count + 1, 0) if count < 0 else count


class _Counting(Control):
    memory: ClassVar[tuple[str, ...]] = ("_completed", "_failures", "_reason")

    def __init__(self, *args: Any, **ports: Any) -> None:
        super().__init__(*args, **ports)
        self._clear()

    def _clear(self) -> None:
        self._completed: list[int] = []
        self._failures = 0
        self._reason = ""

    def _remember_failure(self) -> None:
        self._failures += 1
        if self._node_runtime is not None:
            self._reason = self._node_runtime.reason

    def _recall_reason(self) -> None:
        """Report the reason of the failed child, which may have failed some ticks ago."""
        if self._node_runtime is not None and self._reason:
            self._node_runtime.reason = self._reason

    def _check(self, count: int, verb: str) -> None:
        if len(self.children) < count:
            raise TreeError(f"{len(self.children)} children can never {verb}: {count} must")

    def _halt(self) -> None:
        self._clear()
        super()._halt()


class Parallel(_Counting):
    """Tick all children that have not completed, until enough have succeeded or failed.

    The verdict is checked after each child: on a verdict the later children are not ticked.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | counted; it is not ticked again. SUCCESS once success_count have    |
    | FAILURE | counted; it is not ticked again. FAILURE once failure_count have,   |
    |         | or once success_count cannot be reached                             |
    | RUNNING | RUNNING if there is no verdict                                      |
    | SKIPPED | counts as a success in this tick if success_count is negative;      |
    |         | SKIPPED if all were skipped                                         |
    | halt    | all running children are halted, the counts are cleared             |
    """

    memory: ClassVar = (*_Counting.memory, "_successes")
    success_count = Input(int, default=-1, doc="how many children must succeed; -1 means all")
    failure_count = Input(int, default=1, doc="how many failures end it; -1 means all")

    def _clear(self) -> None:
        super()._clear()
        self._successes = 0

    def _tick(self) -> NodeStatus:
        children = self._child_nodes or self.child_nodes
        count = len(children)
        wanted: int = self.success_count
        needed = threshold(wanted, count)
        tolerated = threshold(self.failure_count, count)
        self._check(needed, "succeed")
        self._check(tolerated, "fail")
        self._enter()
        skipped = 0
        for index, child in enumerate(children):
            if index not in self._completed:
                state = child.execute()
                if state is SUCCESS:
                    self._completed.append(index)
                    self._successes += 1
                elif state is FAILURE:
                    self._completed.append(index)
                    self._remember_failure()
                elif state is SKIPPED:
                    skipped += 1
            if self._successes >= needed or (wanted < 0 and self._successes + skipped >= needed):
                self._clear()
                self._reset_children()
                return SUCCESS
            if count - self._failures < needed or self._failures == tolerated:
                self._recall_reason()
                self._clear()
                self._reset_children()
                return FAILURE
        return SKIPPED if skipped == count else RUNNING


class ParallelAll(_Counting):
    """Tick all children until all have completed, then judge.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | SUCCESS | it is not ticked again                                              |
    | FAILURE | counted; it is not ticked again. When all have completed: FAILURE   |
    |         | if max_failures have failed, else SUCCESS                           |
    | RUNNING | RUNNING                                                             |
    | SKIPPED | counts as completed in this tick; SKIPPED if all were skipped       |
    | halt    | all running children are halted, the counts are cleared             |
    """

    max_failures = Input(int, default=1, doc="how many failures make it fail; -1 means all")

    def _tick(self) -> NodeStatus:
        children = self._child_nodes or self.child_nodes
        count = len(children)
        tolerated = threshold(self.max_failures, count)
        self._check(tolerated, "fail")
        self._enter()
        skipped = 0
        for index, child in enumerate(children):
            if index in self._completed:
                continue
            state = child.execute()
            if state is SUCCESS:
                self._completed.append(index)
            elif state is FAILURE:
                self._completed.append(index)
                self._remember_failure()
            elif state is SKIPPED:
                skipped += 1
        if skipped == count:
            return SKIPPED
        if skipped + len(self._completed) < count:
            return RUNNING
        self._reset_children()
        failed = self._failures >= tolerated
        if failed:
            self._recall_reason()
        self._clear()
        return FAILURE if failed else SUCCESS
