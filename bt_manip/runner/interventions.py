"""Interventions in a running simulation: pulled bodies, and node statuses set by hooks."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from bt_manip.bt import Node, NodeStatus, Tree
from bt_manip.cell import Cell
from bt_manip.exceptions import BtManipError

from .perturbations import MAX_FORCE, Perturbations

if TYPE_CHECKING:
    from .station import Station


_SETS = (NodeStatus.SUCCESS, NodeStatus.FAILURE)

Hook = Callable[..., NodeStatus | None]


class Interventions:
    """Takes requests to intervene from any thread, and applies them in the thread of the run.

    Each intervention is emitted as plain data when it takes effect. A `request` with the same data
    before the same tick repeats it, bit for bit.

    Attributes:
        observers: Called by the thread of the run with the data of each intervention.
        perturbations: The active perturbations, which the thread of the run applies.
    """

    def __init__(self, tree: Tree, station: "Station") -> None:
        self._tree, self._cell = tree, station.cell
        self.observers: list[Callable[[dict[str, Any]], None]] = []
        self._requests: deque[dict[str, Any]] = deque()
        self.perturbations = Perturbations(station.cell, station.robots, self._notify)
        self._hooks: dict[Node, _NodeHooks] = {}

    # Any thread

    def pull(
        self,
        body: str,
        target: Sequence[float] | None,
        *,
        point: Sequence[float] = (0.0, 0.0, 0.0),
        max_force: float = MAX_FORCE,
    ) -> None:
        """Pull a body by a damped spring, as in MuJoCo's window, from the next tick on.

        Args:
            body: Name of an entity other than a robot, or ``entity/body``.
            target: Point in the world to pull it towards [m]; None: let the body go.  # (3,)
            point: Point at which the spring acts, in the frame of the body [m].  # (3,)
            max_force: Limit of the force [N].

        Raises:
            BtManipError: If there is no such body, it cannot move, or a number is not finite.
        """
        goal = None if target is None else [float(x) for x in target]
        spring = {"point": [float(x) for x in point], "target": goal, "max_force": float(max_force)}
        self.request({"kind": "perturbation", "body": body, **spring})

    def override(self, path: str, status: NodeStatus, *, before: bool = True) -> None:
        """Replace the status of a node's next tick.

        Args:
            path: Path of the node.
            status: SUCCESS or FAILURE.
            before: Whether to skip the tick of the node; otherwise its result is replaced.

        Raises:
            BtManipError: If there is no such node, or its status cannot be set.
        """
        data = {"path": path, "before": before, "status": status.name}
        self.request({"kind": "override", **data})

    def request(self, data: Mapping[str, Any]) -> None:
        """Request an intervention by its data, in the emitted form.

        Raises:
            BtManipError: If it is impossible.
        """
        if data["kind"] == "override":
            self._node(data)
        else:
            self.perturbations.check(data)
        self._requests.append(dict(data))

    # The thread of the run

    def take_over(self) -> None:
        """Apply the requests since the last tick; of several perturbations of a body, the last."""
        if not self._requests:
            return
        perturbations = {}
        while self._requests:
            data = self._requests.popleft()
            if data["kind"] == "override":
                self._arm(data)
            else:
                perturbations[data["body"]] = data
        for data in perturbations.values():
            self.perturbations.set(data)

    def set_tick_hooks(
        self, owner: Any, node: Node, pre_tick: Hook | None, post_tick: Hook | None
    ) -> None:
        """Set one owner's functions around a node's tick; statuses that they set are emitted.

        Args:
            owner: Identifies the caller; a later call replaces its functions or, with None, removes
                them.
            node: The node.
            pre_tick: As `bt_manip.bt.Node.set_tick_hooks`.
            post_tick: As `bt_manip.bt.Node.set_tick_hooks`.
        """
        hooks = self._hooks.setdefault(node, _NodeHooks(self._cell, self._notify))
        hooks.owners.pop(owner, None)
        if pre_tick or post_tick:
            hooks.owners[owner] = pre_tick, post_tick
        if hooks.owners:
            node.set_tick_hooks(hooks.before, hooks.after)
        else:
            node.set_tick_hooks()
            del self._hooks[node]

    def clear(self) -> None:
        """End all interventions."""
        self._requests.clear()
        self.perturbations.clear()
        for node in self._hooks:
            node.set_tick_hooks()
        self._hooks.clear()

    def get_state(self) -> dict[str, Any]:
        """Return the active perturbations as plain data."""
        return {"perturbations": self.perturbations.get_state()}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`."""
        self.perturbations.set_state(state.get("perturbations", []))

    # Internal

    def _notify(self, data: dict[str, Any]) -> None:
        for observer in tuple(self.observers):
            observer(data)

    def _node(self, data: Mapping[str, Any]) -> Node:
        node = self._tree.node(data["path"])
        if not isinstance(node, Node):
            raise BtManipError(f"'{node.path}' is of py_trees: its status cannot be set")
        if data["status"] not in (status.name for status in _SETS):
            raise BtManipError(f"a status can be set to SUCCESS or FAILURE, not {data['status']}")
        return node

    def _arm(self, data: dict[str, Any]) -> None:
        """Let the next tick of a node have a status, or one after it in the same tick."""
        try:
            node = self._node(data)
        except BtManipError:  # the tree was edited since the request
            return
        left = data.get("execution", 0)
        owner = object()

        def replace(*_: Any) -> NodeStatus | None:
            nonlocal left
            left -= 1
            if left >= 0:
                return None
            self.set_tick_hooks(owner, node, None, None)
            return NodeStatus[data["status"]]

        self.set_tick_hooks(owner, node, *((replace, None) if data["before"] else (None, replace)))


class _NodeHooks:
    """The hooks of all owners around the tick of a node."""

    def __init__(self, cell: Cell, notify: Callable[[dict[str, Any]], None]) -> None:
        self._cell, self._notify = cell, notify
        self.owners: dict[Any, tuple[Hook | None, Hook | None]] = {}
        self._executions = {True: (-1.0, 0), False: (-1.0, 0)}  # time of the tick, and how many

    def before(self, node: Node) -> NodeStatus | None:
        """Return the status that replaces the node's tick, if one does."""
        return self._call(True, node)

    def after(self, node: Node, state: NodeStatus) -> NodeStatus | None:
        """Return the status that replaces the result, if one does."""
        return self._call(False, node, state)

    def _call(self, before: bool, node: Node, *state: NodeStatus) -> NodeStatus | None:
        time, execution = self._executions[before]
        execution = execution + 1 if time == self._cell.time else 0
        self._executions[before] = self._cell.time, execution
        for hooks in tuple(self.owners.values()):
            hook = hooks[not before]
            status = None if hook is None else hook(node, *state)
            if status in _SETS:
                data = {"path": node.path, "before": before, "status": status.name}
                self._notify({"kind": "override", **data, "execution": execution})
                return status
        return None
