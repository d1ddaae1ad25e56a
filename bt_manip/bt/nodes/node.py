"""The base of all nodes: a py_trees behaviour that is ticked as the engine ticks its nodes."""

import inspect
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.nodes.binding import bind
from bt_manip.bt.nodes.guard import Guard
from bt_manip.bt.nodes.names import CONDITIONS, NodeKind, refuse_reserved
from bt_manip.bt.nodes.names import RESERVED as RESERVED
from bt_manip.bt.nodes.port_access import PortAccess
from bt_manip.bt.nodes.stock_life import StockLife
from bt_manip.bt.ports import Port
from bt_manip.bt.runtime import Observer, Runtime
from bt_manip.bt.status import IDLE, PY_STATUS, RUNNING, SKIPPED, SUCCESS, NodeStatus, Status
from bt_manip.exceptions import NodeError, PortError, did_you_mean

if TYPE_CHECKING:
    from bt_manip.bt.remarks import Comment

_INVALID: Final = Status.INVALID
_SUCCESS: Final = Status.SUCCESS


class Node(PortAccess, StockLife, Behaviour):
    """A node of a tree; see `Action`, `Condition`, `Control` and `Decorator`.

    Attributes:
        kind: Which element of a document it is.
        ports: Its ports by name, from the class's declarations.
        registration: The name under which trees know its class.
        conditions: The scripts around its tick, by attribute (``_skipIf``).
        attributes: Other attributes that came with it from a document, for editors.
        tag: Its element in a document, if that is not its own name: ``Action``.
        remarks: Comments among its children, each with the index of the child that follows.
        is_named: Whether its name was given, and is not only that of its class.
        path: Its path in its tree: the sub-trees that lead to it, and its name.
        uid: Its number in its tree, from 1, depth first.
    """

    kind: ClassVar[NodeKind]
    ports: ClassVar[Mapping[str, Port]] = {}
    memory: ClassVar[tuple[str, ...]] = ()
    """Names of the attributes that make up its state over time, all of them plain data."""
    registration: str = ""

    _node_status: NodeStatus = IDLE
    _node_runtime: Runtime | None = None
    _node_scope: Blackboard | None = None
    _node_observers: list[Observer] | tuple[()] = ()
    _node_guard: Guard | None = None
    path: str = ""
    uid: int = 0
    orphans: tuple[Behaviour, ...] = ()
    """Children of the node that a test replaced by this one: they exist, but nothing ticks them."""

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
                    refuse_reserved(cls, attribute, value)
                    ports[value.name] = value
        cls.ports = ports

    def __init__(self, name: str | None = None, **ports: Any) -> None:
        """Configure the node; nothing is started and nothing is read.

        Args:
            name: Its name; the name of its class if none is given.
            **ports: A value for each port: ``"{key}"`` for an entry of the blackboard, else a
                literal. Also the scripts around its tick: ``skip_if="x > 3"``, ...

        Raises:
            PortError: If there is no such port, or if a literal has the wrong type.
        """
        Behaviour.__init__(self, self.registration if name is None else name)
        self.is_named = name is not None
        self.tag: str | None = None
        self.remarks: list[tuple[int, Comment]] = []
        self.attributes: dict[str, str] = {}
        self.conditions: dict[str, str] = {}
        given: dict[str, Any] = {}
        for key, value in ports.items():
            if key in CONDITIONS:
                if value is not None:
                    self.conditions[CONDITIONS[key]] = value
            else:
                given[self._port_name(key)] = value
        self._start_ports(given)
        if self.conditions:
            self._node_guard = Guard(self.conditions)

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
        """Tick the node and its children, and give the result.

        Raises:
            NodeError: If a node raised an exception.
        """
        if self._node_guard is not None or self._node_observers:
            return self._execute_watched()
        try:
            state = self._tick()
        except NodeError:
            raise
        except Exception as error:
            raise self._error(error) from error
        if state is SUCCESS:
            self._node_status = state
            self.status = _SUCCESS
        elif state is SKIPPED:
            self.status = _INVALID
        elif state is IDLE:
            raise self._error("a tick must not end in IDLE")
        else:
            self._node_status = state
            self.status = PY_STATUS[state]
        return state

    def _execute_watched(self) -> NodeStatus:
        guard = self._node_guard
        try:
            state = guard.before(self) if guard is not None else None
            if state is None:
                state = self._tick()
            if guard is not None:
                state = guard.after(self, state)
        except NodeError:
            raise
        except Exception as error:
            raise self._error(error) from error
        if state is SKIPPED:
            self.status = _INVALID
        else:
            if state is IDLE:
                raise self._error("a tick must not end in IDLE")
            self._set_status(state)
            self.status = PY_STATUS[state]
        runtime = self._node_runtime
        if runtime is not None and runtime.visited is not None:
            runtime.visited.append(self)
        return state

    def _tick(self) -> NodeStatus:
        """Do what this node does at a tick; the status is kept by `execute`."""
        raise NotImplementedError

    def halt(self) -> None:
        """Interrupt the node and what runs below it."""
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
        """Return to idle; what py_trees shows stays, unless the node was running."""
        if self._node_status is not IDLE:
            if self._node_status is RUNNING:
                self.status = _INVALID
            self._set_status(IDLE)

    def _set_status(self, new: NodeStatus) -> None:
        old = self._node_status
        if old is not new:
            self._node_status = new
            for observer in self._node_observers:
                observer(self, old, new)

    def _error(self, error: Exception | str) -> NodeError:
        text = str(error) if isinstance(error, str) else _describe(error)
        path = self.path or self.name
        return NodeError(path, self.registration, text, culprit=type(self).__module__)

    @property
    def links(self) -> list[Any]:
        """The children as this node ticks them; leaves have none."""
        return []

    @property
    def engine_status(self) -> NodeStatus:
        """The engine's status of the node: idle again as soon as its parent has completed."""
        return self._node_status

    # ------------------------------------------------------------------ surroundings

    @property
    def runtime(self) -> Runtime:
        """The surroundings that all nodes of the tree share."""
        if self._node_runtime is None:
            self._bind_alone()
        assert self._node_runtime is not None
        return self._node_runtime

    @property
    def scope(self) -> Blackboard:
        """The blackboard scope that the node's ports and scripts see."""
        if self._node_scope is None:
            self._bind_alone()
        assert self._node_scope is not None
        return self._node_scope

    def _bind_alone(self) -> None:
        """Give the tree around this node surroundings of its own, as no `Tree` did."""
        top: Behaviour = self
        while top.parent is not None:
            top = top.parent
        bind(top, Runtime(), Blackboard())

    @property
    def checked_port(self) -> str:
        """The port that `check_ports` looks at, for the place of its errors."""
        return ""

    def check_ports(self) -> None:
        """Check what must be right before the first tick.

        Raises:
            PortError: If a port is missing or holds what it cannot.
            ScriptError: If a script is none.
        """

    def on_timer(self) -> None:
        """React to the node's timer, before the first tick after its deadline."""

    def _because(self, reason: str) -> None:
        """Remember why this node fails, for people."""
        self.feedback_message = reason
        if self._node_runtime is not None:
            self._node_runtime.reason = (self, reason)

    # ------------------------------------------------------------------ state as plain data

    def get_state(self) -> dict[str, Any]:
        """Give what the node remembers between two ticks, as plain data."""
        return {name: getattr(self, name) for name in self.memory}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take back what `get_state` gave."""
        for name in self.memory:
            setattr(self, name, state[name])

    # ------------------------------------------------------------------ documentation

    @classmethod
    def summary(cls) -> str:
        """Give the first line of the class's documentation."""
        return (inspect.getdoc(cls) or "").partition("\n")[0]


def _describe(error: Exception) -> str:
    return str(error) if str(error) else type(error).__name__
