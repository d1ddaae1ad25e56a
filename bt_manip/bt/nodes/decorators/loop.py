"""LoopInt, LoopBool, LoopDouble, LoopString: the child for each item of a queue."""

from collections import deque
from collections.abc import Mapping
from typing import Any, ClassVar

from bt_manip.bt.blackboard import EMPTY
from bt_manip.bt.literals import split_list
from bt_manip.bt.nodes.parent import Decorator
from bt_manip.bt.port_types import (
    BOOL,
    BOOL_LIST,
    DOUBLE,
    DOUBLE_LIST,
    INT,
    INT_LIST,
    STATUS,
    STRING,
    STRING_LIST,
    PortType,
)
from bt_manip.bt.ports import InOut, Input, Output, is_pointer, pointed_key
from bt_manip.bt.status import FAILURE, IDLE, RUNNING, SUCCESS, NodeStatus
from bt_manip.exceptions import shown


class Loop(Decorator):
    """Tick the child once for each item of a queue, and hand the item to it.

    | child   | result                                                              |
    |---------|---------------------------------------------------------------------|
    | empty   | the status of the port if_empty; the child is not ticked            |
    | SUCCESS | RUNNING; the next tick takes the next item                          |
    | FAILURE | FAILURE                                                             |
    | RUNNING | RUNNING; the next tick goes on with this item                       |
    | SKIPPED | RUNNING; the next tick takes the next item                          |
    | halt    | the child is halted; a queue that was given as text starts anew     |

    The queue is a text such as ``1;2;3``, or an entry that holds such a text or a list: both start
    anew with each round. An entry that holds a ``collections.deque`` is consumed in place.
    """

    checked_port = "queue"
    item: ClassVar[PortType]
    items: ClassVar[PortType]

    def __init__(self, *args: Any, **ports: Any) -> None:
        super().__init__(*args, **ports)
        self._queue: deque[Any] | None = None
        self._child_running = False

    def check_ports(self) -> None:
        """Raise a `PortError` if the queue is missing, or is a text that holds something else."""
        text = self.given.get("queue")
        if text is None:
            raise self._port_error("queue", "nothing was given")
        if isinstance(text, str) and not is_pointer(text):
            self._from_text(text)

    def _tick(self) -> NodeStatus:
        queue = self.given.get("queue")
        literal = not isinstance(queue, str) or not is_pointer(queue)
        if self._node_status is IDLE:
            self._child_running = False
            self._queue = None
            if literal:
                self._queue = (
                    self._from_text(queue) if isinstance(queue, str) else deque(queue or ())
                )
        if not self._child_running:
            if not literal:
                assert isinstance(queue, str)
                self._look_up(pointed_key("queue", queue) or "")
            if not self._queue:
                result: NodeStatus = self.read_port("if_empty")
                if result is FAILURE:
                    self._because("the queue is empty")
                return result
            item = self._queue.popleft()
            if self.key_of("value") is not None:
                self.write_port("value", item)
        if self._node_status is IDLE:
            self._enter()
        state = self.child_node.execute()
        self._child_running = state is RUNNING
        if state is SUCCESS or state is FAILURE:
            self._reset_child()
        return FAILURE if state is FAILURE else RUNNING

    def _look_up(self, key: str) -> None:
        entry = self.scope.entry(key)
        if entry is None:
            self.scope.declare(key)
            entry = self.scope.entry(key)
        if entry is None:  # remapped to a root key that does not exist: there is no queue
            return
        value = entry.value
        if value is EMPTY:
            raise self._port_error("queue", f"the blackboard entry '{key}' was never written")
        if isinstance(value, deque):
            self._queue = value
        elif self._queue is None:
            if entry.type == self.items or (isinstance(value, list) and not value):
                self._queue = deque(value)
            elif isinstance(value, str):
                self._queue = self._from_text(value)
            else:
                raise self._port_error(
                    "queue", f"expected a list of {self.item.name} or a text, found {shown(value)}"
                )

    def _from_text(self, text: str) -> deque[Any]:
        parse = self.item.parse
        assert parse is not None
        try:
            return deque(parse(part) for part in split_list(text))
        except ValueError as error:
            raise self._port_error("queue", str(error)) from None

    def get_state(self) -> dict[str, Any]:
        """Return the rest of the queue, and whether the child runs."""
        return {
            "queue": None if self._queue is None else list(self._queue),
            "child_running": self._child_running,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state that `get_state` returned."""
        self._queue = None if state["queue"] is None else deque(state["queue"])
        self._child_running = state["child_running"]


def _loop(name: str, item: PortType, items: PortType) -> type[Loop]:
    body = {
        "__doc__": f"A Loop over items of type {item.name}.\n\n"
        + (Loop.__doc__ or "").partition("\n\n")[2],
        "__module__": __name__,
        "item": item,
        "items": items,
        "queue": InOut(doc="the items: a text such as 1;2;3, or an entry"),
        "if_empty": Input(STATUS, default=SUCCESS, doc="status when no item is left"),
        "value": Output(item, doc="the item that the child works on"),
    }
    return type(name, (Loop,), body)


LoopInt = _loop("LoopInt", INT, INT_LIST)
LoopBool = _loop("LoopBool", BOOL, BOOL_LIST)
LoopDouble = _loop("LoopDouble", DOUBLE, DOUBLE_LIST)
LoopString = _loop("LoopString", STRING, STRING_LIST)
