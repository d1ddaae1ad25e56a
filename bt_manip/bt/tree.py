"""A tree that runs: its nodes, blackboard and clock, and the methods to tick it."""

import re
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from itertools import chain
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn

from py_trees.behaviour import Behaviour

from bt_manip.bt.blackboard import Blackboard
from bt_manip.bt.goal import bind_goal, reads_cell
from bt_manip.bt.nodes.binding import OnProblem, bind
from bt_manip.bt.nodes.decorators.repeat import Counting
from bt_manip.bt.nodes.node import Node
from bt_manip.bt.nodes.tree_node import TreeNode, behaviour_of
from bt_manip.bt.ports import is_pointer
from bt_manip.bt.runtime import Clock, Observer, Runtime
from bt_manip.bt.status import FAILURE, RUNNING, SUCCESS, NodeStatus
from bt_manip.bt.tree_state import get_tree_state, set_tree_state
from bt_manip.exceptions import NodeError, TreeError, did_you_mean

if TYPE_CHECKING:
    from bt_manip.bt.xml.document import Document
    from bt_manip.bt.xml.problem import Problem

MAX_ROUNDS: Final = 100_000
"""How often a tree is ticked again at once, within one tick."""

_FRAMES_PER_LEVEL = 6
_FRAMES_AROUND = 500
_NODE_STATUS = attrgetter("_node_status")


class Tree:
    """A tree of behaviours with a blackboard and a clock.

    Args:
        root: The root: a node, or any stock py_trees behaviour.
        clock: Returns the time [s] that Delay, Timeout and Sleep count.
        blackboard: The scope of the root; a new one if none is given.
        enums: Numbers that scripts know by name.
        tree_id: The ID of the tree.
        document: The document it was read from.
        on_problem: Collects the problems of the nodes; without it the first error is raised.
        goal: Conditions that hold when the tree has done its task: one or several. A run fails
            where they do not.
        task: A sentence that says what it does, for data sets, or ``{key}``, the entry of the
            blackboard that has it; default: its ID in words.
        results: Keys of the blackboard whose values are the results of a cycle.
        continues: Whether a cycle begins in the cell as the one before has left it; else each
            begins in the cell as it was at the start of the run.

    Attributes:
        nodes: All nodes, depth first; stock py_trees behaviours are wrapped in a `ForeignNode`.
        observers: Called as ``observer(node, old, new)`` on each change of a node's status.
        given_task: The `task` as given.
        goal: Conditions of the goal; after the set-up, one for each object that a condition names.
        given_goal: The `goal` as given.
        results: Keys of the results.
        continues: As given.
        scopes: The blackboard scopes by the path of their sub-tree, ``""`` for the root's.
        warnings: Warnings of the checks of its document.
        constants: By node path and port, the only text that its entry can hold when it is read.

    Raises:
        TreeError: If a behaviour occurs in it twice, two sub-trees have the same path, it is
            deeper than 256 levels, or the goal is no condition.
    """

    def __init__(
        self,
        root: Behaviour,
        *,
        clock: Clock = time.monotonic,
        blackboard: Blackboard | None = None,
        enums: Mapping[str, int] | None = None,
        tree_id: str | None = None,
        document: "Document | None" = None,
        on_problem: OnProblem | None = None,
        goal: Node | Iterable[Node] = (),
        task: str = "",
        results: Iterable[str] = (),
        continues: bool = False,
    ) -> None:
        self.root = root
        self.tree_id = root.name if tree_id is None else tree_id
        self.document = document
        self.given_task = task
        self.results, self.continues = tuple(results), continues
        self._runtime = Runtime(clock)
        self._runtime.enums.update(enums or {})
        self.observers: list[Observer] = self._runtime.observers
        binding = bind(root, self._runtime, blackboard or Blackboard(), on_problem)
        self.nodes: list[TreeNode] = binding.nodes
        self.scopes = binding.scopes
        self.given_goal = bind_goal(goal, self.blackboard, self._runtime, on_problem)
        self.goal = self.given_goal
        self._root: TreeNode = self.nodes[0]
        self.warnings: tuple[Problem, ...] = ()
        self.constants: dict[tuple[str, str], str] = {}
        self._has_foreign = not all(isinstance(node, Node) for node in self.nodes)
        self._infrastructure: dict[str, Any] | None = None
        frames = binding.depth * _FRAMES_PER_LEVEL + _FRAMES_AROUND
        sys.setrecursionlimit(max(frames, sys.getrecursionlimit()))

    @property
    def task(self) -> str:
        """The task as a sentence: given, read from the blackboard, or the tree's ID in words."""
        if is_pointer(self.given_task):
            text = self.blackboard.get(self.given_task.strip()[1:-1])
            given = text if isinstance(text, str) else ""
        else:
            given = self.given_task
        words = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|[\W_]+", " ", self.tree_id)
        return given or words.strip().lower()

    # ------------------------------------------------------------------ running

    def setup(self, **infrastructure: Any) -> None:
        """Hand infrastructure to all behaviours, before the first tick.

        Args:
            **infrastructure: The arguments of every ``setup``: a cell, an arm, ... Conditions of
                the goal get those in ``judged`` instead, where it is given.

        Raises:
            NodeError: If the ``setup`` of a behaviour raised an exception.
        """
        self._infrastructure = infrastructure.copy()
        judged = infrastructure.pop("judged", infrastructure)
        goal = {*map(id, self.given_goal)}
        for node in (*self.nodes, *self.given_goal):
            behaviour, given = behaviour_of(node), judged if id(node) in goal else infrastructure
            try:
                if isinstance(node, Node):
                    node.set_up_ports(given)
                behaviour.setup(**given)
            except Exception as error:
                message, culprit = f"setup: {error}", type(behaviour).__module__
                raise NodeError(node.path, node.registration, message, culprit) from error
        parts = [getattr(one, "goal_conditions", ()) or (one,) for one in self.given_goal]
        self.goal = tuple(chain.from_iterable(parts))

    def tick(self, node: TreeNode | None = None) -> NodeStatus:
        """Tick the tree, and again at once as long as it is woken up.

        Args:
            node: The node to tick in place of the root; no other one may be running above it.

        Returns:
            The status of the root; when it has completed, the root is idle afterwards.

        Raises:
            NodeError: If a node raised an exception, or if the tree was woken up more than
                `MAX_ROUNDS` times.
        """
        runtime = self._runtime
        if runtime.timers:
            runtime.fire_timers()
        root = self._root if node is None else node
        status = root.execute()
        rounds = 0
        while status is RUNNING and runtime.wake_up:
            rounds += 1
            if rounds > MAX_ROUNDS:
                self._raise_endless()
            runtime.wake_up = False
            status = root.execute()
        if status is RUNNING:
            return status
        if status is SUCCESS or status is FAILURE:
            root._reset()
        return status

    def _raise_endless(self) -> NoReturn:
        """Raise the error of a tick that does not end, a mistake in the tree."""
        loops = (n for n in reversed(self.nodes) if isinstance(n, Counting))
        node = next((node for node in loops if node.engine_status is RUNNING), self._root)
        child = node.child_nodes[0].name if node.child_nodes else "it"
        text = (
            f"'{child}' answered at once {MAX_ROUNDS} times within one tick; limit the number of "
            "rounds, or repeat something that takes time"
        )
        raise NodeError(node.path, node.registration, text) from TreeError(text)

    def tick_exactly_once(self) -> NodeStatus:
        """Tick the tree once; wake-ups are ignored.

        Returns:
            The status of the root; when it has completed, the root is idle afterwards.

        Raises:
            NodeError: If a node raised an exception.
        """
        self._runtime.fire_timers()
        status = self._root.execute()
        if status is SUCCESS or status is FAILURE:
            self._root._reset()
        return status

    def halt(self) -> None:
        """Halt the running nodes, and set all nodes to idle.

        As in the engine, the ``_onHalted`` scripts of all nodes run, of idle ones too.

        Raises:
            NodeError: If a node raised an exception while it was halted.
        """
        self._runtime.fire_timers()
        self._root.halt()
        for node in self.nodes:
            node.halt()
        self._root._reset()

    def shutdown(self) -> None:
        """Shut all behaviours down."""
        for node in (*self.nodes, *self.goal):
            behaviour_of(node).shutdown()

    # ------------------------------------------------------------------ access

    @property
    def blackboard(self) -> Blackboard:
        """The blackboard scope of the root."""
        return self.scopes[""]

    @property
    def clock(self) -> Clock:
        """Returns the time [s] that the tree counts."""
        return self._runtime.clock

    @clock.setter
    def clock(self, clock: Clock) -> None:
        self._runtime.clock = clock

    def statuses(self) -> bytes:
        """Return the engine's status of every node, one byte a node, in the order of `nodes`."""
        if self._has_foreign:
            return bytes([node.engine_status for node in self.nodes])
        return bytes(map(_NODE_STATUS, self.nodes))

    @property
    def is_running(self) -> bool:
        """Whether the root has been ticked and has not completed."""
        return self._root.engine_status is RUNNING

    @property
    def goal_reads_cell(self) -> bool:
        """Whether a condition of the goal can read the cell, and not only the blackboard."""
        return reads_cell(self.goal)

    def node(self, path: str) -> TreeNode:
        """Find a node by its path.

        Raises:
            TreeError: If there is no such node.
        """
        for node in self.nodes:
            if node.path == path:
                return node
        raise TreeError(f"no node '{path}'" + did_you_mean(path, [n.path for n in self.nodes]))

    def result_values(self) -> dict[str, Any]:
        """Return the values of its `results`; None for what was not written."""
        return {key: self.blackboard.get(key) for key in self.results}

    def place_of(self, path: str) -> str:
        """Return where a node stands, ``file:line:column``; empty without a document."""
        return self.places().get(path, "")

    def places(self) -> dict[str, str]:
        """Return where each node and condition of the goal stands, by path, as `place_of` does."""
        return {node.path: str(node._node_place) for node in (*self.nodes, *self.given_goal)}

    def failure_reason(self) -> str:
        """Return which node failed last, and why: ``path: reason``, or an empty text."""
        return self._runtime.reason

    def __iter__(self) -> Iterator[TreeNode]:
        """Iterate over all nodes, depth first."""
        return iter(self.nodes)

    # ------------------------------------------------------------------ state as plain data

    def get_state(self) -> dict[str, Any]:
        """Return the state of all nodes and blackboards as plain data."""
        return get_tree_state(self.nodes, self.scopes, self._runtime)

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore the state that `get_state` returned, in a tree of the same shape.

        Raises:
            TreeError: If the state is of another tree.
        """
        set_tree_state(state, self.nodes, self.scopes, self._runtime)

    # ------------------------------------------------------------------ replacing

    def replace(self, other: "Tree") -> None:
        """Become another tree: running nodes are halted, the blackboard and the clock stay.

        The entries of every scope that both trees have stay, with those that only the new tree
        declares added. Observers and infrastructure stay.

        Args:
            other: A tree that was just built and has not run, perhaps set up; it must not be used
                afterwards.

        Raises:
            NodeError: If a node raised an exception while it was halted or set up; this tree is
                halted then, and stays.
        """
        self.halt()
        if self._infrastructure is not None and other._infrastructure is None:
            other.setup(**self._infrastructure)
        runtime = self._runtime
        for path, scope in other.scopes.items():
            old = self.scopes.get(path)
            if old is not None:
                _keep_entries(old, scope)
        runtime.timers.clear()
        runtime.wake_up = False
        runtime.reason = ""
        runtime.enums.update(other._runtime.enums)
        kept = ("_runtime", "observers", "_infrastructure")
        vars(self).update((name, new) for name, new in vars(other).items() if name not in kept)
        for node in self.nodes:
            node._node_runtime = runtime
            node._node_observers = runtime.observers

    @property
    def source(self) -> Path | None:
        """The file that the tree was read from, if any."""
        return None if self.document is None else self.document.path

    def __repr__(self) -> str:
        """Show the tree's ID and size."""
        return f"Tree({self.tree_id!r}, {len(self.nodes)} nodes)"

    def _repr_svg_(self) -> str:
        """Show the nodes with their statuses in a notebook."""
        from bt_manip.bt.drawing import draw_svg

        return draw_svg(self, ports=False)


def _keep_entries(old: Blackboard, new: Blackboard) -> None:
    """Keep the written entries, unless the new tree gives the key another type or meaning."""
    for key, entry in old.entries.items():
        fresh = new.entries.get(key)
        if key in new.remapped:
            continue
        if fresh is None:
            new.entries[key] = entry
        elif fresh.sequence == 0 and (
            not fresh.declared.strong
            or fresh.declared == entry.declared
            or not entry.declared.strong
        ):
            new.entries[key] = entry
