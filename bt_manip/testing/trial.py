"""Trial: a behaviour or a tree in a station, ticked by a test."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from py_trees.behaviour import Behaviour

from bt_manip.bt import Blackboard, NodeStatus, Tree
from bt_manip.exceptions import NodeError, did_you_mean
from bt_manip.runner import Run, RunLoop, Station, TreeSource, make_modifiers
from bt_manip.testing.history import History, explain
from bt_manip.testing.stubs import status_of


class Trial:
    """A behaviour or a tree in a station, ticked by a test.

    A failed expectation raises an `AssertionError` with the node that decided, the tick, the status
    of all nodes, and the blackboard.

    Args:
        root: A behaviour, or a tree whose clock is the station's.
        modifiers: Texts of each modifier that acts until the root ends or is halted, by its name.
        seed: Seed of the modifiers; None: that of the station.

    Attributes:
        station: The station.
        tree: The tree.
        history: Recorded changes of its nodes.
    """

    def __init__(
        self,
        station: Station,
        root: Behaviour | Tree,
        *,
        modifiers: Mapping[str, tuple[str, ...]] | None = None,
        seed: int | None = None,
    ) -> None:
        if not isinstance(root, Tree | Behaviour):
            raise TypeError(f"a trial is of a behaviour or a tree, got {root!r}")
        self.station = station
        self.tree = root if isinstance(root, Tree) else Tree(root, clock=station.clock)
        self.history = History(self.tree)
        self.tree.observers.append(self.history)
        self.tree.setup(**station.infrastructure)
        source = TreeSource(self.tree.tree_id, "python")
        seed = station.request.seed if seed is None else seed
        request = replace(station.request, tree=source, modifiers=modifiers or {}, seed=seed)
        self._problems: list[str] = []
        run = Run(request, self.tree, station)
        run.modifiers = make_modifiers(run, self._problems.append)
        self._loop = RunLoop(run)
        self._loop.open()
        self._loop.begin(in_place=True)

    @property
    def behaviour(self) -> Behaviour:
        """The root."""
        return self.tree.root

    @property
    def blackboard(self) -> Blackboard:
        """The blackboard scope of the root."""
        return self.tree.blackboard

    # Ticking

    def tick(self) -> NodeStatus:
        """Tick once and step the simulation until the next tick.

        Raises:
            AssertionError: When the root ends and a modifier has warned, as of a fault that has
                not happened.
        """
        __tracebackhide__ = True
        self.history.tick += 1
        try:
            status = self._loop.advance()
        except NodeError as error:
            error.add_note(self.explain())
            raise
        if status is not NodeStatus.RUNNING:
            self._loop.end(status)
            if self._problems:
                raise AssertionError("\n".join([*self._problems, self.explain()]))
        return status

    def until_done(self, timeout: float = 3.0) -> NodeStatus:
        """Tick until the root ends, for at most some simulated time [s]."""
        end = self.station.cell.time + timeout
        status = self.tick()
        while status is NodeStatus.RUNNING and self.station.cell.time < end - 1e-9:
            status = self.tick()
        return status

    def tick_until(
        self,
        wanted: NodeStatus | str | Callable[[], bool],
        timeout: float = 3.0,
        *,
        node: str = "",
    ) -> NodeStatus:
        """Tick until a status or a condition occurs.

        Args:
            wanted: The status of the root (``"SUCCESS"``, ...) or of a node, or a condition that
                is checked after each tick.
            timeout: Longest simulated time to wait [s].
            node: Path, name or registered name of the node with this status; the root when empty.

        Returns:
            The root's status at the last tick.

        Raises:
            AssertionError: When the tree ends otherwise, or after the timeout.
        """
        __tracebackhide__ = True
        status_wanted = None if callable(wanted) else status_of(wanted)
        watched = self.node(node) if node else None
        end = self.station.cell.time + timeout
        while True:
            seen = len(self.history.changes)
            status = self.tick()
            if status_wanted is None:
                assert callable(wanted)
                if wanted():
                    return status
            elif watched is None:
                if status is status_wanted:
                    return status
            elif any(
                c.node is watched and c.status is status_wanted for c in self.history.changes[seen:]
            ):
                return status
            what = "the condition" if status_wanted is None else status_wanted.name
            of = f" of '{watched.path or watched.name}'" if watched is not None else ""
            if status is not NodeStatus.RUNNING:
                raise AssertionError(f"expected {what}{of}, the tree ended with {status.name}\n"
                                     + self.explain())  # fmt: skip
            if self.station.cell.time >= end - 1e-9:
                raise AssertionError(f"expected {what}{of} within {timeout:g} s, the tree still "
                                     f"runs\n{self.explain()}")  # fmt: skip

    def halt(self) -> None:
        """Halt the tree and end all modifiers."""
        self.tree.halt()
        for modifier in self._loop.run.modifiers:
            modifier.run_ended()

    # Checks

    def node(self, name: str) -> Any:
        """Return a node by its path, name or registered name.

        Raises:
            AssertionError: When there is none, or more than one.
        """
        __tracebackhide__ = True
        for attribute in ("path", "name", "registration"):
            found = [node for node in self.tree.nodes if getattr(node, attribute) == name]
            if len(found) == 1:
                return found[0]
            if found:
                paths = ", ".join(f"'{node.path}'" for node in found)
                raise AssertionError(f"'{name}' may be any of {paths}")
        known = [node.path for node in self.tree.nodes]
        raise AssertionError(f"the tree has no node '{name}'{did_you_mean(name, known)}")

    def fails_with(self, *words: str, timeout: float = 3.0) -> bool:
        """Run to the end and assert a failure whose reason contains these words.

        Returns:
            True, so that a test can say ``assert trial(...).fails_with(...)``.

        Raises:
            AssertionError: When it does not fail, or for another reason.
        """
        __tracebackhide__ = True
        self.tick_until(NodeStatus.FAILURE, timeout)
        reason = self.tree.failure_reason()
        missing = [word for word in words if word not in reason]
        if missing:
            raise AssertionError(
                f"expected a failure with {', '.join(map(repr, missing))} in its reason\n"
                + self.explain()
            )
        return True

    def assert_ended(self, node: str, status: NodeStatus | str) -> None:
        """Assert that a node has ended with a status, at any tick.

        Raises:
            AssertionError: When it has not.
        """
        __tracebackhide__ = True
        wanted, ended_node, running = status_of(status), self.node(node), NodeStatus.RUNNING
        changes = [c.status for c in self.history.changes if c.node is ended_node]
        ends = [change for change in changes if change is not running]
        if wanted not in ends:
            ended = ", ".join(end.name for end in ends) or "not at all"
            raise AssertionError(
                f"expected '{node}' to end with {wanted.name}, it ended {ended}\n" + self.explain()
            )

    def assert_never_ticked(self, node: str) -> None:
        """Assert that a node has not been ticked.

        Raises:
            AssertionError: When it has.
        """
        __tracebackhide__ = True
        change = self.history.last(self.node(node))
        if change is not None:
            raise AssertionError(
                f"expected '{node}' never to be ticked, it was {change.status.name} at tick "
                f"{change.tick}\n" + self.explain()
            )

    def explain(self) -> str:
        """Describe the ticks so far."""
        return explain(self.history)
