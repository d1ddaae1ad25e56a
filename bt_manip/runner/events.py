"""The events of a run as plain data, for viewers and recorders."""

import math
from collections import deque
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, NamedTuple

from bt_manip.bt import NodeStatus, pointed_key
from bt_manip.bt.nodes import TreeNode
from bt_manip.cell import ContactEventDetector, as_object
from bt_manip.exceptions import BtManipError

from .observer import RunObserver

if TYPE_CHECKING:
    from .run import Run


class RunEvent(NamedTuple):
    """One event; `data` holds numbers, strings, bools, None, and lists of these.

    ======================  ====================================================================
    kind                    keys of `data`
    ======================  ====================================================================
    ``tree``                ``nodes``: uid, path, name, kind, registration, parent and ``ports`` of
                            each node; of a port: name, direction, text as in a document, and the
                            ``key`` of the blackboard that it points to, if any; ``results``: the
                            keys of the tree's results
    ``edit``                ``problems`` of the edited file of the tree, a line for each; none when
                            the tree has been replaced
    ``cycle``               ``cycle``; ``status`` (``RUNNING`` when it starts), ``reason``
    ``status``              ``uid``, ``path``, ``old``, ``status``, ``reason`` of a failure; of
                            nodes that are halted their last ``message``, of nodes that use a robot
                            the ``robot``
    ``message``             ``uid``, ``path``, ``text``: the feedback message of a node that runs or
                            has succeeded, when it changes
    ``blackboard``          ``key`` with its sub-tree's path, ``value`` (None if unset), ``type``
    ``entity``              ``name``, ``kind``, ``present``
    ``contact``             ``first``, ``second``, ``touching``
    ``motion``              ``robot``, ``moving``, ``duration`` [s], ``fault``
    ``controller``          ``robot``, ``controller``
    ``intervention``        ``kind``: ``perturbation`` (a body is pulled) or ``override``. The
                            former has ``body``, ``point`` in its frame [m], ``target`` in the
                            world [m] (None when it ends), ``max_force`` [N] and ``begins``; an
                            override has ``path``, ``status``, ``before`` (instead of the node's
                            tick, or after it) and ``execution``, the number of the node's
                            execution in the tick
    ``tick``                ``tick``: number of the tick, from 0
    ======================  ====================================================================
    """

    time: float
    """Simulated time [s]."""
    kind: str
    data: dict[str, Any]


Listener = Callable[[RunEvent], None]

KINDS = (
    "tree", "edit", "cycle", "status", "message", "blackboard", "entity", "contact", "motion",
    "controller", "intervention", "tick",
)  # fmt: skip
"""All kinds of events."""


class EventStream:
    """Makes the events of a run once, for all listeners; a kind that nobody wants costs nothing.

    The first events describe the state at the start of the run. Statuses are emitted when they
    change, everything else after each tick. Listeners are called by the thread of the run, which
    waits for them: use an `EventQueue` for another thread.
    """

    def __init__(self, run: "Run") -> None:
        self._run, self._cell, self._tree = run, run.station.cell, run.tree
        self._listeners: dict[str, list[Listener]] = {kind: [] for kind in KINDS}
        self._kinds: set[str] = set()  # that are wanted
        self._nodes: Sequence[TreeNode] | None = None
        self._entries: dict[str, tuple[Any, int]] = {}  # blackboard entries and their sequences
        self._written: list[Any] = []  # the same without their keys
        self._entities: dict[str, Any] = {}
        self._generation: int | None = None
        self._detector: ContactEventDetector | None = None
        self._trajectories: dict[str, Any] = dict.fromkeys(run.station.robots)
        self._controllers: dict[str, str] = {}
        self._messages: dict[int, str] = {}  # by uid
        self._tick, self._cycle = 0, run.cycle
        self._tick_time = self._cell.time

    def listen(self, listener: Listener, kinds: Iterable[str] = KINDS) -> None:
        """Call a function with each event of some kinds; to be called before `start`.

        Raises:
            BtManipError: If there is no such kind.
        """
        for kind in kinds:
            if kind not in self._listeners:
                raise BtManipError(f"no events are of the kind '{kind}': {', '.join(KINDS)}")
            self._listeners[kind].append(listener)
            self._kinds.add(kind)

    def emit(self, kind: str, data: dict[str, Any], time: float | None = None) -> None:
        """Emit an event.

        Args:
            kind: Its kind.
            data: Its data, as `RunEvent` documents them.
            time: Simulated time [s]; None: now.
        """
        if listeners := self._listeners[kind]:
            event = RunEvent(self._cell.time if time is None else time, kind, data)
            for listener in listeners:
                listener(event)

    # The loop

    def start(self) -> None:
        """Observe the tree and interventions, until the loop is closed."""
        if self._wanted("status", "message"):
            self._tree.observers.append(self._status_changed)
        if self._wanted("intervention"):
            self._run.interventions.observers.append(partial(self.emit, "intervention"))

    def after_compile(self) -> None:
        """Emit entities that were added or removed."""
        self._compare_tree()
        self._compare_entities()

    def begin_cycle(self, cycle: int) -> None:
        """Emit the state at the start, and the cycle."""
        self._cycle, self._tick_time = cycle, self._cell.time
        self._compare()
        self.emit("cycle", {"cycle": cycle, "status": "RUNNING", "reason": ""})

    def end_tick(self) -> None:
        """Emit all changes since the last tick."""
        if self._kinds:
            self._compare()
            self.emit("tick", {"tick": self._tick})
        self._tick += 1
        self._tick_time = self._cell.time

    def end_cycle(self, status: str, reason: str) -> None:
        """Emit the end of the cycle."""
        self.emit("cycle", {"cycle": self._cycle, "status": status, "reason": reason})

    # Internal

    def _wanted(self, *kinds: str) -> bool:
        return not self._kinds.isdisjoint(kinds)

    def _status_changed(self, node: TreeNode, old: NodeStatus, new: NodeStatus) -> None:
        if self._tree.nodes is self._nodes:
            self._emit_status(node, old, new)
        else:  # replaced by an edited tree
            self._compare_tree()

    def _emit_status(self, node: TreeNode, old: NodeStatus, new: NodeStatus) -> None:
        if self._wanted("status"):
            reason = str(node.feedback_message) if new is NodeStatus.FAILURE else ""
            data = {"uid": node.uid, "path": node.path, "old": old.name, "status": new.name}
            data["reason"] = reason
            if old is NodeStatus.RUNNING and new in (NodeStatus.IDLE, NodeStatus.SKIPPED):
                data["message"] = str(node.feedback_message)
            if robot := getattr(node, "robot_name", ""):
                data["robot"] = robot
            self.emit("status", data)
        if new is NodeStatus.SUCCESS and self._wanted("message"):
            self._emit_message(node)

    def _emit_message(self, node: TreeNode) -> None:
        text = str(node.feedback_message)
        if text != self._messages.get(node.uid, ""):
            self._messages[node.uid] = text
            self.emit("message", {"uid": node.uid, "path": node.path, "text": text})

    def _compare(self) -> None:
        """Emit all changes except status changes."""
        self._compare_tree()
        self._compare_entities()
        if self._wanted("message"):
            for node in self._tree.nodes:
                if node.engine_status is NodeStatus.RUNNING:
                    self._emit_message(node)
        if self._wanted("blackboard"):
            self._compare_blackboard()
        if self._wanted("contact"):
            self._compare_contacts()
        if self._wanted("motion", "controller"):
            self._compare_robots()

    def _compare_tree(self) -> None:
        if self._tree.nodes is self._nodes or not self._wanted("tree", "status", "message"):
            return
        self._nodes = self._tree.nodes
        self._messages.clear()
        paths = {id(scope): path for path, scope in self._tree.scopes.items()}
        parents = {id(child): link.uid for link in self._nodes for child in link.children}
        nodes = [
            {
                "uid": link.uid,
                "path": link.path,
                "name": link.name,
                "kind": str(link.kind),
                "registration": link.registration,
                "parent": parents.get(id(getattr(link, "behaviour", link)), 0),
                "ports": list(_ports(link, paths)),
            }
            for link in self._nodes
        ]
        self.emit("tree", {"nodes": nodes, "results": list(self._tree.results)})
        for link in self._nodes:
            if link.engine_status is not NodeStatus.IDLE:
                self._emit_status(link, NodeStatus.IDLE, link.engine_status)

    def _compare_entities(self) -> None:
        if self._cell.generation == self._generation or not self._wanted("entity"):
            return
        self._generation = self._cell.generation
        before, self._entities = self._entities, dict(self._cell.entities)
        for present, these, others in (
            (False, before, self._entities), (True, self._entities, before)
        ):  # fmt: skip
            for name, entity in these.items():
                if others.get(name) is not entity:
                    kind = as_object(entity).kind
                    self.emit("entity", {"name": name, "kind": kind, "present": present})

    def _compare_blackboard(self) -> None:
        scopes = self._tree.scopes
        written = [
            part
            for scope in scopes.values()
            for entry in scope.entries.values()
            for part in (entry, entry.sequence)
        ]
        if written == self._written:
            return
        self._written = written
        entries, present = self._entries, set()
        for path, scope in scopes.items():
            for name, entry in scope.entries.items():
                key = f"{path}/{name}" if path else name
                present.add(key)
                if entries.get(key) != (entry, entry.sequence):
                    entries[key] = (entry, entry.sequence)
                    if entry.sequence:
                        data = {"key": key, "value": _plain_value(entry), "type": entry.type.name}
                        self.emit("blackboard", data, self._tick_time)
        if len(entries) > len(present):
            for key in [key for key in entries if key not in present]:
                del entries[key]
                self.emit("blackboard", {"key": key, "value": None, "type": ""}, self._tick_time)

    def _compare_contacts(self) -> None:
        contacts = self._cell.contacts
        if self._detector is None:
            self._detector = ContactEventDetector(contacts)
            for first, second in contacts.pairs():
                self.emit("contact", {"first": first, "second": second, "touching": True})
        for event in self._detector.update(contacts, self._cell.time):
            data = {"first": event.first, "second": event.second, "touching": event.begins}
            self.emit("contact", data)

    def _compare_robots(self) -> None:
        for name, robot in self._run.station.robots.items():
            arm, active = robot.arm, robot.controllers.active
            if arm.trajectory is not self._trajectories[name]:
                self._trajectories[name] = arm.trajectory
                duration = arm.trajectory.duration if arm.trajectory and arm.moving else 0.0
                data = {"robot": name, "moving": arm.moving, "duration": float(duration)}
                time = self._tick_time if arm.moving else self._cell.time
                self.emit("motion", {**data, "fault": arm.fault}, time)
            if active != self._controllers.get(name):
                self._controllers[name] = active
                self.emit("controller", {"robot": name, "controller": active})


class EventQueue(RunObserver):
    """Hands events to another thread; a full queue drops the oldest, so the run never waits.

    Args:
        size: Largest number of events in it.
        kinds: Kinds of the events that it takes.

    Attributes:
        dropped: Number of dropped events.
    """

    def __init__(self, size: int = 10_000, kinds: Collection[str] = KINDS) -> None:
        self.kinds = kinds
        self._events: deque[RunEvent] = deque(maxlen=size)
        self.dropped = 0

    def handle(self, event: RunEvent) -> None:
        """Add an event."""
        if len(self._events) == self._events.maxlen:
            self.dropped += 1
        self._events.append(event)

    def take(self) -> list[RunEvent]:
        """Return the events since the last call, and remove them."""
        taken = []
        while self._events:
            taken.append(self._events.popleft())
        return taken


def _ports(link: Any, paths: Mapping[int, str]) -> Iterator[dict[str, str]]:
    """Yield the ports and scripts of a node, and the remaps of a sub-tree."""
    texts = {name: ("script", text) for name, text in link.conditions.items()}
    texts |= {name: ("remap", text) for name, text in getattr(link, "remaps", {}).items()}
    for name, port in link.ports.items():
        texts[name] = port.direction, link.port_text(name) or ""
    for name, (direction, text) in texts.items():
        pointed, key = pointed_key(name, text), ""
        if pointed is not None and direction != "script":
            scope, entry = link.scope.place(pointed)
            key = "/".join(filter(None, (paths.get(id(scope)), entry)))
        yield {"name": name, "direction": direction, "text": text, "key": key}


def _plain_value(entry: Any) -> bool | int | float | str | None | list[Any]:
    """Return the value of a blackboard entry as JSON can hold it; other types become text."""
    value = entry.value
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if value is None or isinstance(value, bool | int | float | str):
        return value
    try:
        return str(value) if entry.type.format is None else entry.type.format(value)
    except (ValueError, TypeError):
        return str(value)
