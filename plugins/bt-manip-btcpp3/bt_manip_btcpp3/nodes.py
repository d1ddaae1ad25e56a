"""The nodes of BehaviorTree.CPP 3.8 that differ from those of version 4.

Checked against version 3.8.8: ``src/controls``, ``src/decorators`` and ``src/xml_parsing.cpp`` of
its branch ``v3.8``. No child is ever skipped there, and a tick never pauses to be woken up again.
"""

from collections.abc import Mapping
from typing import Any, ClassVar

from bt_manip import bt
from bt_manip.bt import Blackboard, Control, Decorator, Input, NodeStatus
from bt_manip.exceptions import PortError

FAILURE, IDLE = NodeStatus.FAILURE, NodeStatus.IDLE
RUNNING, SUCCESS = NodeStatus.RUNNING, NodeStatus.SUCCESS


OUTSIDE = "__outside"
"""Attribute of a SubTree: constants after ``__autoremap`` are written to the caller's entries."""


class SequenceStar(Control):
    """Tick the children one after the other; go on with the one that failed.

    | child   | result                                                               |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | the next child is ticked; after the last one SUCCESS                 |
    | FAILURE | FAILURE; the next round starts with this child                       |
    | RUNNING | RUNNING; the next tick goes on with this child                       |
    | halt    | the children are halted, the next round starts with the first        |
    """

    memory: ClassVar = ("_index",)
    _index = 0

    def _tick(self) -> NodeStatus:
        children = self.child_nodes
        self._enter()
        while self._index < len(children):
            state = children[self._index].execute()
            if state is RUNNING:
                return RUNNING
            if state is FAILURE:
                for index in range(self._index, len(children)):
                    self._halt_child(index)
                return FAILURE
            self._index += 1
        self._halt()
        return SUCCESS

    def _halt(self) -> None:
        self._index = 0
        super()._halt()


class Parallel(Control):
    """Tick all children that have not completed; count them in their order at every tick.

    | child   | result                                                               |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | it is not ticked again. SUCCESS at the success_threshold-th one      |
    | FAILURE | it is not ticked again. FAILURE at the failure_threshold-th one, or  |
    |         | once success_threshold cannot be reached                             |
    | RUNNING | RUNNING if there is no verdict                                       |
    | halt    | the children are halted, the counts are cleared                      |

    `threshold` is what versions 3.0 to 3.5 have: failures count only where it cannot be reached.
    """

    memory: ClassVar = ("_completed",)
    success_threshold = Input(int, default=None, doc="how many must succeed; -1: all")
    failure_threshold = Input(int, default=1, doc="how many failures end it; -1: all")
    threshold = Input(int, default=None, doc="as success_threshold, in versions 3.0 to 3.5")
    _completed: Mapping[int, NodeStatus] = {}

    def _tick(self) -> NodeStatus:
        children = self.child_nodes
        count = len(children)
        old = "threshold" in self.given
        needed = _threshold(self.read_port("threshold" if old else "success_threshold"), count)
        most = count + 1 - needed if old else _threshold(self.failure_threshold, count)
        if count < max(needed, 0 if old else most):
            raise ValueError(f"{count} children are fewer than a threshold")
        self._enter()
        seen = {SUCCESS: 0, FAILURE: 0}
        for index, child in enumerate(children):
            state = self._completed.get(index) or child.execute()
            if state is RUNNING:
                continue
            self._completed = {**self._completed, index: state}
            seen[state] += 1
            verdict = (state is SUCCESS and seen[SUCCESS] == needed) or (
                state is FAILURE and (seen[FAILURE] > count - needed or seen[FAILURE] == most)
            )
            if verdict:
                self._completed = {}
                self._reset_children()
                return state
        return RUNNING

    def _halt(self) -> None:
        self._completed = {}
        super()._halt()


def _threshold(count: int, children: int) -> int:
    return children + count + 1 if count < 0 else count


def _tick_rounds(self: Any) -> NodeStatus:
    """Tick the child until it was counted often enough, or ends otherwise."""
    most = self.read_port(self.port)
    self._enter()
    while most == -1 or self._count < most:
        before = self.child_node.engine_status
        state: NodeStatus = self.child_node.execute()
        if state is RUNNING:
            return RUNNING
        self._reset_child()
        if state is not self._counted:
            self._count = 0
            return state
        self._count += 1
        if most == -1 and before is IDLE:
            return RUNNING
    self._count = 0
    return self._counted


class Repeat(bt.Repeat):
    """Tick the child until it has succeeded a number of times, again and again in one tick.

    | child   | result                                                               |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | counted; SUCCESS after num_cycles, else it starts anew in this tick  |
    | FAILURE | FAILURE, the count starts anew                                       |
    | RUNNING | RUNNING                                                              |
    | halt    | the child is halted, the count starts anew                           |

    -1 cycles never end; a child that never runs is ticked once per tick then, where the engine
    would hang.
    """

    _tick = _tick_rounds


class RetryUntilSuccessful(bt.RetryUntilSuccessful):
    """Tick the child until it succeeds, a number of times at most, again and again in one tick.

    | child   | result                                                               |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | SUCCESS, the count starts anew                                       |
    | FAILURE | counted; FAILURE after num_attempts, else it starts anew in this     |
    |         | tick                                                                 |
    | RUNNING | RUNNING                                                              |
    | halt    | the child is halted, the count starts anew                           |

    -1 attempts never end; a child that never runs is ticked once per tick then, where the engine
    would hang.
    """

    _tick = _tick_rounds


class _Check(Decorator):
    """Tick the child as long as two values are equal; they are compared at every tick.

    | child    | result                                                              |
    |----------|---------------------------------------------------------------------|
    | not      | the child is halted, and return_on_mismatch is returned; so too     |
    | equal    | where a value is missing or of another type                         |
    | SUCCESS  | SUCCESS                                                             |
    | FAILURE  | FAILURE                                                             |
    | RUNNING  | RUNNING                                                             |
    | halt     | the child is halted                                                 |
    """

    value_A = Input(doc="a value, or {key}")
    value_B = Input(doc="the value that it is compared with, or {key}")
    return_on_mismatch = Input(NodeStatus, default=FAILURE, doc="result where they differ")
    _type: ClassVar[bt.PortType] = bt.STRING

    def _tick(self) -> NodeStatus:
        self._enter()
        if self._equal():
            state = self.child_node.execute()
            if state is not RUNNING:
                self._reset_child()
            return state
        self._reset_child()
        try:
            return NodeStatus(self.return_on_mismatch)
        except PortError:
            return FAILURE

    def _equal(self) -> bool:
        try:
            first, second = (self.read_port(name, self._type) for name in ("value_A", "value_B"))
        except PortError:
            return False
        return abs(first - second) <= 2.0**-23 if self._type is bt.DOUBLE else first == second


def _check(name: str, python: type) -> Any:
    members = {"__doc__": _Check.__doc__, "__module__": __name__, "_type": Input(python).type}
    return type(name, (_Check,), members)


BlackboardCheckInt = _check("BlackboardCheckInt", int)
BlackboardCheckDouble = _check("BlackboardCheckDouble", float)
BlackboardCheckString = _check("BlackboardCheckString", str)
BlackboardCheckBool = _check("BlackboardCheckBool", bool)


class SetBlackboard(bt.SetBlackboard):
    """Write a text, or the value of another entry, to an entry; no type is checked in a copy.

    | tick | SUCCESS; an entry that is not there to be copied is an error of the tree           |
    |------|------------------------------------------------------------------------------------|
    | halt | nothing                                                                            |
    """

    def _tick(self) -> NodeStatus:
        key = self.read_port("output_key", bt.STRING)
        text = self.port_text("value") or ""
        target = self.scope.entry(key)
        if bt.is_pointer(text):
            source = self.scope.entry(text[1:-1])
            if source is None:
                raise PortError(f"no entry '{text[1:-1]}' to copy")
            if target is None:
                target = self.scope.declare(key, source.declared)
            target.put(source.value, source.type)
            return SUCCESS
        if target is None:
            target = self.scope.declare(key)
        declared = target.declared
        if not declared.strong or declared.converter is None:
            target.put(text, bt.STRING)
            return SUCCESS
        try:
            target.put(declared.converter(text), declared)
        except ValueError as error:
            raise PortError(f"entry '{key}': {error}") from None
        return SUCCESS


class SubTree(bt.SubTree):
    """Tick the root of another tree, in a blackboard scope of its own or in the same.

    | child   | result                                                               |
    |---------|----------------------------------------------------------------------|
    | SUCCESS | SUCCESS                                                              |
    | FAILURE | FAILURE                                                              |
    | RUNNING | RUNNING                                                              |
    | halt    | the child is halted                                                  |

    Constants are texts, never numbers. With ``__shared_blackboard`` the scope is the outer one.
    """

    def make_scope(self, outer: Blackboard) -> Blackboard:
        """Return the inner scope, with its remaps and constants."""
        if self.attributes.get("__shared_blackboard"):
            self.inner_scope = outer
            return outer
        scope = super().make_scope(outer)
        outside = self.attributes.get(OUTSIDE, "").split()
        for key, text in self.remaps.items():
            if not bt.is_pointer(text):
                scope.unset(key)
                scope.autoremap = key in outside
                scope.declare(key).put(text, bt.STRING)
        scope.autoremap = self.autoremap
        return scope


def _switch(base: type[Any]) -> Any:
    def choose(self: Any) -> int:
        """Return the case that equals the variable as a text; the last child without one."""
        try:
            variable = self.read_port("variable")
        except PortError:
            return len(self.cases)
        for index, name in enumerate(self.cases):
            try:
                if self.read_port(name) == variable:
                    return index
            except PortError:
                continue
        return len(self.cases)

    doc = "Tick the child whose case equals the variable as a text, or else the last child."
    members = {"__doc__": doc, "__module__": __name__, "_choose": choose}
    return type(base.__name__, (base,), members)


Switch2, Switch3, Switch4, Switch5, Switch6 = map(
    _switch, (bt.Switch2, bt.Switch3, bt.Switch4, bt.Switch5, bt.Switch6)
)
