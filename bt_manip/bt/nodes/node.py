"""The base of all nodes: a py_trees behaviour that is ticked as the engine ticks its nodes."""

import inspect
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from py_trees.behaviour import Behaviour

from bt_manip.bt.nodes.guard import CONDITIONS, Guard, PostTick, PreTick
from bt_manip.bt.nodes.port_access import PortAccess
from bt_manip.bt.nodes.tree_node import NodeKind as NodeKind
from bt_manip.bt.nodes.tree_node import TreeNode
from bt_manip.bt.ports import Port
from bt_manip.bt.runtime import Observer, Runtime
from bt_manip.bt.script.parser import parse_script
from bt_manip.bt.status import (
    FAILURE,
    IDLE,
    PY_STATUS,
    RUNNING,
    SKIPPED,
    SUCCESS,
    NodeStatus,
    Status,
)
from bt_manip.exceptions import NodeError, PortError, TreeError, did_you_mean, with_short_values

RESERVED: Final = frozenset({"name", "ID", "_autoremap", *CONDITIONS.values()})
"""Attributes in a document that are never ports."""

_ATTRIBUTES: Final = frozenset({
    "name", "id", "status", "parent", "children", "logger", "feedback_message", "blackboards",
    "blackbox_level", "iterator", "qualified_name", "attributes", "conditions", "decorated",
    "current_child", "given", "is_named",
})  # fmt: skip
"""Attributes of instances in Python, which no port can replace."""

_INVALID: Final = Status.INVALID


@dataclass(frozen=True)
class Comment:
    """A comment among the children of a node, in Python as in a document.

    Attributes:
        text: The text between ``<!--`` and ``-->``.
        kind: ``comment``; or ``text`` for text, which the tree language ignores.
    """

    text: str
    kind: str = "comment"


class Node(PortAccess):
    """A node of a tree; see `Action`, `Condition`, `Control` and `Decorator`.

    Args:
        name: Its name; the name of its class if none is given.
        **ports: A value for each port: ``"{key}"`` for an entry of the blackboard, else a literal.
            Also the scripts around its tick: ``skip_if="x > 3"``, ...

    Attributes:
        conditions: The scripts around its tick, by attribute (``_skipIf``).
        attributes: Other attributes that came with it from a document, for editors.
        is_named: Whether its name was given, and is not only that of its class.
        checked_port: The port that `check_ports` checks, for the place of its errors.

    Raises:
        PortError: If there is no such port, or if a literal has the wrong type.
        ScriptError: If a script is invalid.
    """

    checked_port: ClassVar[str] = ""
    _node_status: NodeStatus = IDLE
    _node_runtime: Runtime | None = None
    _node_observers: list[Observer] | tuple[()] = ()
    _node_guard: Guard | None = None
    _node_drawn: Mapping[str, Any] = {}
    """Values that were written last to the outputs in `drawn`."""
    _node_tag: str | None = None
    """Its element in a document, if that is not its own name: ``Action``."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
        """Collect the class's ports.

        Raises:
            TypeError: If a port has a name that py_trees or the tree language needs.
        """
        super().__init_subclass__(**kwargs)
        if "registration" not in cls.__dict__:
            cls.registration = cls.__name__
        ports: dict[str, Port] = {}
        for base in reversed(cls.__mro__):
            for attribute, value in vars(base).items():
                if isinstance(value, Port):
                    _refuse_reserved(cls, attribute, value)
                    ports[value.name] = value
        cls.ports = ports

    def __init__(self, name: str | None = None, **ports: Any) -> None:
        Behaviour.__init__(self, self.registration if name is None else name)
        self.is_named = name is not None
        self._node_comments: list[tuple[int, Comment]] = []  # with the index of the next child
        self.attributes: dict[str, str] = {}
        self.conditions = {}
        given: dict[str, Any] = {}
        for key, value in ports.items():
            if key in CONDITIONS:
                if value is not None:
                    self.conditions[CONDITIONS[key]] = value
            else:
                given[self._port_name(key)] = value
        self._start_ports(given)
        if self.conditions:
            self._node_guard = Guard({k: parse_script(s) for k, s in self.conditions.items()})

    def _port_name(self, key: str) -> str:
        if key in self.ports:
            return key
        for port in self.ports.values():
            if port.attribute == key:
                return port.name
        raise PortError(
            f"{type(self).__name__} has no port '{key}'"
            + did_you_mean(key, [*self.ports, *CONDITIONS])
        )

    # ------------------------------------------------------------------ ticking

    def execute(self) -> NodeStatus:
        """Tick the node and its children, and return the result.

        Raises:
            NodeError: If a node raised an exception.
        """
        guard = self._node_guard
        try:
            if guard is None:
                state = self._tick()
            else:
                before = guard.before(self)
                state = guard.after(self, self._tick() if before is None else before)
        except NodeError:
            raise
        except Exception as error:
            raise self._error(error) from error
        observers = self._node_observers
        if state is SKIPPED:
            self.status = _INVALID
        elif state is IDLE:
            idle = TreeError("a tick must not end in IDLE")
            raise self._error(idle) from idle
        elif state is not RUNNING or self._node_status is not RUNNING:
            if observers:
                self._set_status(state)
            else:
                self._node_status = state
            self.status = PY_STATUS[state]
        if observers:
            runtime = self._node_runtime
            if runtime is not None and runtime.visited is not None:
                runtime.visited.append(self)
        return state

    def _tick(self) -> NodeStatus:
        """Return the result of a tick; `execute` keeps it as the status."""
        raise NotImplementedError

    def halt(self) -> None:
        """Interrupt the node and its running children."""
        try:
            self._halt()
            if self._node_guard is not None:
                self._node_guard.halted(self)
        except NodeError:
            raise
        except Exception as error:
            raise self._error(error) from error

    def _halt(self) -> None:
        self._reset()

    def _reset(self) -> None:
        """Return to idle; py_trees' status stays, unless the node was running."""
        if self._node_status is not IDLE:
            if self._node_status is RUNNING:
                self.status = _INVALID
            self._set_status(IDLE)

    def _error(self, error: Exception | str) -> NodeError:
        text = str(error) or type(error).__name__
        path = self.path or self.name
        return NodeError(path, self.registration, text, culprit=type(self).__module__)

    # ------------------------------------------------------------------ below stock py_trees

    def tick(self) -> Iterator[Behaviour]:
        """Tick the node for a stock py_trees parent or tree, and yield the nodes it ticked."""
        if self._node_status is SUCCESS or self._node_status is FAILURE:
            self._reset()
        runtime = self.runtime
        if runtime.visited is not None:  # a stock node between two of ours: the outer one reports
            self.execute()
            return
        if not _is_below_node(self):
            runtime.fire_timers()
        visited: list[Behaviour] = []
        runtime.visited = visited
        runtime.observers.append(_ignore)
        try:
            self.execute()
        finally:
            runtime.visited = None
            runtime.observers.remove(_ignore)
        yield from visited

    def stop(self, new_status: Status) -> None:
        """Stop the node for a stock py_trees parent."""
        if new_status is _INVALID:
            if self._node_status is RUNNING:
                self.halt()
            self._reset()
        else:
            self.terminate(new_status)
        self.status = new_status

    def update(self) -> Any:
        """Not used by nodes with children."""
        return _INVALID

    # ------------------------------------------------------------------ checks and timers

    def check_ports(self) -> None:
        """Check the ports before the first tick.

        Raises:
            PortError: If a port is missing or holds an invalid value.
            ScriptError: If a port holds an invalid script.
        """

    def set_tick_hooks(
        self, pre_tick: PreTick | None = None, post_tick: PostTick | None = None
    ) -> None:
        """Set the functions around the node's tick, for debuggers; None removes one.

        Args:
            pre_tick: As `Guard.pre_tick`.
            post_tick: As `Guard.post_tick`.
        """
        if self._node_guard is None:
            if pre_tick is None and post_tick is None:
                return
            self._node_guard = Guard({})
        self._node_guard.pre_tick, self._node_guard.post_tick = pre_tick, post_tick

    def on_timer(self) -> None:
        """React to the node's timer, before the first tick after its deadline."""

    def _because(self, reason: str) -> None:
        """Set the reason why this node fails."""
        self.feedback_message = with_short_values(reason)
        if self._node_runtime is not None:
            self._node_runtime.failed(self.path or self.name, reason)

    @classmethod
    def summary(cls) -> str:
        """Return the first line of the class's documentation."""
        return (inspect.getdoc(cls) or "").partition("\n")[0]


def _refuse_reserved(cls: type, attribute: str, port: Port) -> None:
    """Raise a `TypeError` for a port with a name that py_trees or the tree language needs."""
    taken = attribute in _ATTRIBUTES or any(
        attribute in vars(base) and not isinstance(vars(base)[attribute], Port)
        for base in cls.__mro__
    )
    if taken or attribute in CONDITIONS:
        raise TypeError(f"{cls.__name__}.{attribute}: a port cannot be named '{attribute}'")
    if port.name in RESERVED or not port.name[:1].isalpha():
        raise TypeError(f"{cls.__name__}.{attribute}: a port cannot be named '{port.name}'")


def _is_below_node(node: Behaviour) -> bool:
    parent = node.parent
    while parent is not None:
        if isinstance(parent, TreeNode):
            return True
        parent = parent.parent
    return False


def _ignore(node: Any, old: Any, new: Any) -> None:
    """Observe nothing: only makes nodes report that they were ticked."""
