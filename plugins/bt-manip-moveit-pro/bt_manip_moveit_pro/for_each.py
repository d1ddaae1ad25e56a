"""ForEach of MoveIt Pro: the child for each item of a list."""

from typing import Any, ClassVar

from bt_manip.bt import Decorator, Input, NodeStatus, Output

FAILURE, IDLE = NodeStatus.FAILURE, NodeStatus.IDLE
RUNNING, SUCCESS = NodeStatus.RUNNING, NodeStatus.SUCCESS


class ForEach(Decorator):
    """Tick the child once for each item of a list, and hand the item and its index to it.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | empty   | SUCCESS; the child is not ticked                                    |
    | SUCCESS | the next tick takes the next item; SUCCESS after the last one       |
    | FAILURE | FAILURE                                                             |
    | RUNNING | RUNNING; the next tick goes on with this item                       |
    | SKIPPED | as SUCCESS                                                          |
    | halt    | the child is halted; the next round starts with the first item      |
    """

    memory: ClassVar = ("_position",)
    _ends_with: ClassVar[NodeStatus] = FAILURE
    _at_the_end: ClassVar[NodeStatus] = SUCCESS
    vector_in = Input(doc="the items: a list, or a text such as 1;2;3")
    out = Output(doc="the item that the child works on")
    index = Output(int, doc="its index, from 0")
    _position = 0

    def _tick(self) -> NodeStatus:
        items: Any = self.read_port("vector_in")
        if isinstance(items, str):
            items = items.removesuffix(";").split(";") if items else []
        if self._node_status is IDLE:
            self._position = 0
        if self._position >= len(items):
            return self._end()
        child = self.child_node
        if child._node_status is not RUNNING:
            for name, value in (("out", items[self._position]), ("index", self._position)):
                if self.is_connected(name):
                    self.write_port(name, value)
        self._enter()
        state = child.execute()
        if state is RUNNING:
            return RUNNING
        self._reset_child()
        if state is self._ends_with:
            return state
        self._position += 1
        return self._end() if self._position >= len(items) else RUNNING

    def _end(self) -> NodeStatus:
        if self._at_the_end is FAILURE:
            self._because("the child succeeded with none of the items")
        return self._at_the_end

    def _halt(self) -> None:
        self._position = 0
        super()._halt()


class ForEachUntilSuccess(ForEach):
    """Tick the child with one item of a list after another, until it succeeds.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | empty   | FAILURE; the child is not ticked                                    |
    | SUCCESS | SUCCESS; `out` and `index` stay those of this item                  |
    | FAILURE | the next tick takes the next item; FAILURE after the last one       |
    | RUNNING | RUNNING; the next tick goes on with this item                       |
    | SKIPPED | as FAILURE                                                          |
    | halt    | the child is halted; the next round starts with the first item      |
    """

    _ends_with: ClassVar = SUCCESS
    _at_the_end: ClassVar = FAILURE
