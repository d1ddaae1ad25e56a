"""Nav2's control nodes (nav2_behavior_tree/plugins/control of ros-navigation/navigation2)."""

from typing import ClassVar

from bt_manip.bt import Control, InOut, Input, NodeStatus
from bt_manip.exceptions import PortError

FAILURE, RUNNING = NodeStatus.FAILURE, NodeStatus.RUNNING
SKIPPED, SUCCESS = NodeStatus.SKIPPED, NodeStatus.SUCCESS


class RecoveryNode(Control):
    """Tick the first child; where it fails, tick the second, the recovery, and try again.

    | child            | result                                                         |
    |------------------|----------------------------------------------------------------|
    | first SUCCESS    | SUCCESS, the count starts anew                                 |
    | first FAILURE    | the recovery is ticked; FAILURE after number_of_retries        |
    | recovery SUCCESS | counted; the first child is ticked again, in the same tick     |
    | recovery FAILURE | FAILURE, the count starts anew                                 |
    | RUNNING          | RUNNING; the next tick goes on with this child                 |
    | first SKIPPED    | SKIPPED, the count starts anew                                 |
    | recovery SKIPPED | FAILURE; the next round starts with the first child, the count |
    |                  | stays                                                          |
    | halt             | the children are halted, the count starts anew                 |
    """

    memory: ClassVar[tuple[str, ...]] = ("_index", "_retries")
    least_children: ClassVar = 2
    most_children: ClassVar = 2
    number_of_retries = Input(int, default=1, doc="how many recoveries are tried")
    _index = 0
    _retries = 0

    def check_ports(self) -> None:
        """Check that there are two children.

        Raises:
            PortError: If there are not.
        """
        if len(self.children) != 2:
            raise PortError(f"{self.name} must have 2 children; it has {len(self.children)}")

    def _tick(self) -> NodeStatus:
        most = self.number_of_retries
        main, recovery = self.child_nodes
        self._enter()
        while self._retries <= most:
            if self._index == 0:
                state = main.execute()
                if state is RUNNING:
                    return RUNNING
                if state is not FAILURE or self._retries >= most:
                    if state is FAILURE:
                        self._because(f"{main.name} failed after {self._retries} recoveries")
                    self._halt()
                    return state
                self._halt_child(0)
                self._index = 1
            else:
                state = recovery.execute()
                if state is RUNNING:
                    return RUNNING
                if state is FAILURE:
                    self._because(f"the recovery {recovery.name} failed")
                    break
                self._index = 0
                self._halt_child(1)
                if state is SKIPPED:
                    self._because(f"the recovery {recovery.name} was skipped")
                    return FAILURE
                self._retries += 1
        self._halt()
        return FAILURE

    def _halt(self) -> None:
        self._index = self._retries = 0
        super()._halt()


class PipelineSequence(Control):
    """Tick the children in order, those before the running one again at each tick.

    | child   | result                                                                  |
    |---------|-------------------------------------------------------------------------|
    | SUCCESS | the next child is ticked; after the last one SUCCESS                    |
    | FAILURE | all are halted, FAILURE                                                 |
    | RUNNING | RUNNING if no later child was reached yet; else the next one is ticked  |
    | SKIPPED | as SUCCESS; SKIPPED if all were skipped in this tick                    |
    | halt    | the children are halted, the next round starts with the first           |
    """

    memory: ClassVar[tuple[str, ...]] = ("_reached",)
    _reached = 0

    def _tick(self) -> NodeStatus:
        skipped = 0
        for index, child in enumerate(self.child_nodes):
            state = child.execute()
            if state is FAILURE:
                self._end()
                return FAILURE
            if state is SKIPPED:
                skipped += 1
            elif state is RUNNING and index >= self._reached:
                self._reached = index
                return RUNNING
        self._end()
        return SKIPPED if skipped == len(self.child_nodes) else SUCCESS

    def _end(self) -> None:
        self._reset_children()
        self._reached = 0

    def _halt(self) -> None:
        self._reached = 0
        super()._halt()


class RoundRobin(Control):
    """Tick one child after the other until one succeeds; the next round goes on after it.

    | child   | result                                                                  |
    |---------|-------------------------------------------------------------------------|
    | SUCCESS | SUCCESS; the next round starts with the next child                      |
    | FAILURE | the next child is ticked; FAILURE once all have failed                  |
    | RUNNING | RUNNING; the next tick goes on with this child                          |
    | SKIPPED | as FAILURE; SKIPPED if all were skipped                                 |
    | halt    | the children are halted, the next round starts with the first           |

    Without wrap_around, a round ends with the last child: FAILURE, also where it succeeds.
    """

    memory: ClassVar[tuple[str, ...]] = ("_index", "_failed")
    wrap_around = Input(bool, default=False, doc="go on with the first child after the last one")
    _index = 0
    _failed = 0

    def _tick(self) -> NodeStatus:
        children = self.child_nodes
        wraps = self.wrap_around
        self._enter()
        skipped = 0
        while self._failed + skipped < len(children):
            state = children[self._index].execute()
            if state is RUNNING:
                return RUNNING
            self._index += 1
            at_end = self._index == len(children)
            if at_end and wraps:
                self._index = 0
            if state is FAILURE:
                self._failed += 1
            elif state is SKIPPED:
                skipped += 1
            elif wraps or not at_end:
                self._failed = 0
                self._reset_children()
                return SUCCESS
            if at_end and not wraps:
                break
        self._halt()
        if skipped == len(children):
            return SKIPPED
        self._because("no child that was left succeeded")
        return FAILURE

    def _halt(self) -> None:
        self._index = self._failed = 0
        super()._halt()


class NonblockingSequence(Control):
    """Tick all children at each tick, until all succeed in the same one.

    | child   | result                                                                  |
    |---------|-------------------------------------------------------------------------|
    | SUCCESS | SUCCESS if all children return it, else RUNNING                         |
    | FAILURE | all are halted, FAILURE                                                 |
    | RUNNING | the next child is ticked, RUNNING                                       |
    | SKIPPED | an error, as in Nav2                                                    |
    | halt    | the children are halted                                                 |
    """

    def _tick(self) -> NodeStatus:
        running = False
        for child in self.child_nodes:
            state = child.execute()
            if state is SKIPPED:
                raise ValueError(f"the child {child.name} was skipped; NonblockingSequence cannot")
            if state is FAILURE:
                self._reset_children()
                return FAILURE
            running |= state is RUNNING
        if running:
            return RUNNING
        self._reset_children()
        return SUCCESS


class PersistentSequence(Control):
    """Tick the children in order, and keep the index of the present one in an entry.

    | child   | result                                                                  |
    |---------|-------------------------------------------------------------------------|
    | SUCCESS | the next child is ticked; after the last one SUCCESS and index 0        |
    | FAILURE | FAILURE and index 0                                                     |
    | RUNNING | RUNNING; the next tick goes on with this child                          |
    | SKIPPED | as SUCCESS                                                              |
    | halt    | the children are halted; the index stays                                |
    """

    current_child_idx = InOut(int, doc="index of the present child, from 0")

    def _tick(self) -> NodeStatus:
        index: int = self.current_child_idx
        children = self.child_nodes
        self._enter()
        while index < len(children):
            state = children[index].execute()
            if state is RUNNING:
                return RUNNING
            if state is FAILURE:
                self._reset_children()
                self.current_child_idx = 0
                return FAILURE
            index += 1
            self.current_child_idx = index
        self._reset_children()
        self.current_child_idx = 0
        return SUCCESS
