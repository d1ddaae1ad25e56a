"""Injection of faults into a run."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.bt import NodeStatus
from bt_manip.registry import Registry
from bt_manip.runner import Run, RunModifier

from .fault import Fault, FaultContext, FaultError
from .planned_fault import PlannedFault

if TYPE_CHECKING:
    from bt_manip.bt import Node


class FaultInjector(RunModifier):
    """Begins and ends planned faults.

    Args:
        planned: The planned faults.
        faults: The registered faults.
        seed: Seed of the faults; None: that of the run.
        warn: Called with the reason why a planned fault did not occur in a cycle.
    """

    def __init__(
        self,
        planned: Sequence[PlannedFault],
        faults: Registry[Callable[..., Any]],
        seed: int | None = 0,
        warn: Callable[[str], None] = lambda message: None,
    ) -> None:
        self._planned, self._faults, self._seed, self._warn = planned, faults, seed, warn
        self._active: list[tuple[float, Fault]] = []
        self._pending: list[_Pending] = []
        self._cycle, self._begun = 0, list[PlannedFault]()

    def run_started(self, run: Run) -> None:
        """Connect to the run.

        Raises:
            FaultError: If its tree has no node of a planned fault.
        """
        self._of_run = run.request.seed if self._seed is None else self._seed
        self._station, self._tree, self._cell = run.station, run.tree, run.station.cell
        self._nodes = [planned.nodes(run.tree) for planned in self._planned]
        run.tree.observers.append(self._node_changed)  # until the run has ended

    def cycle_started(self, cycle: int) -> None:
        """Schedule the faults of a cycle."""
        self._pending = [
            _Pending(planned, nodes, np.random.default_rng((self._of_run, cycle, number)))
            for number, (planned, nodes) in enumerate(zip(self._planned, self._nodes, strict=True))
            if planned.cycle in (0, cycle + 1)
        ]
        self._cycle = cycle
        self._begun.clear()

    @property
    def missed(self) -> list[str]:
        """The planned faults that have not begun in this cycle, also those of other cycles."""
        return [f"fault '{planned}'" for planned in self._planned if planned not in self._begun]

    def before_tick(self) -> None:
        """Begin due faults, and end expired ones."""
        now = self._cell.time + 1e-9
        for ending in [one for one in self._active if one[0] <= now]:
            self._active.remove(ending)
            ending[1].end()
        for pending in [one for one in self._pending if one.due <= now]:
            self._pending.remove(pending)
            self._begin(pending)

    def after_compile(self) -> None:
        """Bind active faults to the new model."""
        for _, fault in self._active:
            fault.bind()

    def cycle_ended(self, status: str, reason: str) -> None:
        """Undo all faults, the last one first."""
        for pending in self._pending:
            began = "ended too early" if pending.node else "was not reached"
            self._note(pending.planned, f"'{pending.planned.at}' {began}")
        self._pending.clear()
        self._end_all()

    def run_ended(self) -> None:
        """Undo all faults."""
        for planned in self._planned:
            if planned.cycle > self._cycle + 1:
                self._warn(f"fault '{planned}' did not happen: there was no cycle {planned.cycle}")
        self._pending.clear()
        self._end_all()

    def _begin(self, pending: "_Pending") -> None:
        fault = pending.planned.make(self._faults)
        context = FaultContext(self._station, self._tree, pending.node, pending.rng)
        try:
            fault.start(context)
        except FaultError as error:
            self._note(pending.planned, str(error))
            return
        self._begun.append(pending.planned)
        self._active.append((self._cell.time + fault.duration, fault))

    def _note(self, planned: PlannedFault, problem: str) -> None:
        self._warn(f"fault '{planned}' did not happen in cycle {self._cycle + 1}: {problem}")

    def _end_all(self) -> None:
        while self._active:
            self._active.pop()[1].end()

    def _node_changed(self, node: "Node", old: NodeStatus, new: NodeStatus) -> None:
        if old is NodeStatus.IDLE:
            for pending in self._pending:
                if pending.node is None and node in pending.nodes:
                    pending.node = node
                    pending.due = self._cell.time + pending.planned.after


@dataclass(eq=False)
class _Pending:
    """A planned fault that has not begun in this cycle.

    Attributes:
        node: The node that has started; None before.
        due: Simulated time at which it begins [s].
    """

    planned: PlannedFault
    nodes: Sequence[Any]
    rng: np.random.Generator
    node: Any = None
    due: float = math.inf
