"""The one loop: ticks of a tree, control steps of a cell, and whoever watches."""

import contextlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass

from bt_manip.bt import NodeStatus, Tree
from bt_manip.runner.observer import RunObserver
from bt_manip.runner.pacing import Pacing
from bt_manip.runner.request import RunRequest
from bt_manip.runner.station import Station

Stop = Callable[[], bool]

BRAKING = 3.0
"""Longest time that an arm gets to come to rest after something has raised [s]."""


@dataclass(frozen=True)
class Run:
    """A tree that is ready to run in a station."""

    request: RunRequest
    tree: Tree
    station: Station

    def execute(self, observers: Sequence[RunObserver] = (), *, stop: Stop = lambda: False) -> None:
        """Run the tree for as many cycles as asked.

        Args:
            observers: Who watches; `RunObserver` says what is called when.
            stop: Asked once per tick; when it says yes, the tree is halted and the run ends.

        Raises:
            Exception: What a behaviour, a controller or an observer raised; every observer has
                been told that the run has ended.
        """
        _Loop(self, observers, stop).run()


class _Loop:
    """The state of one execution."""

    def __init__(self, run: Run, observers: Sequence[RunObserver], stop: Stop) -> None:
        self._tree, self._cell = run.tree, run.station.cell
        self._run, self._request, self._stop = run, run.request, stop
        self._observers = observers
        self._before_tick = _overridden("before_tick", observers)
        self._after_step = _overridden("after_step", observers)
        self._generation: int | None = None
        self._pacing = Pacing(run.request.real_time)

    def run(self) -> None:
        """Go through the cycles."""
        started: list[RunObserver] = []
        try:
            for observer in self._observers:
                started.append(observer)
                observer.run_started(self._run)
            self._note_model()
            self._pacing.start(self._cell.time)
            cycle = 0
            while self._request.cycles == 0 or cycle < self._request.cycles:
                if not self._cycle(cycle):
                    break
                cycle += 1
        except Exception:
            self._brake()
            raise
        finally:
            self._end(started)

    def _brake(self) -> None:
        """Bring the arm to rest, as far as the physics and those who watch still work.

        What raises here follows from what raised before, and that is what has to be told.
        """
        with contextlib.suppress(Exception):
            self._tree.halt()
        with contextlib.suppress(Exception):
            arm = self._run.station.arm
            if arm.moving:
                arm.stop()
            end = self._cell.time + BRAKING
            while arm.moving and self._cell.time < end:
                self._steps()

    def _end(self, started: Sequence[RunObserver]) -> None:
        """Halt the tree and tell everyone, even when one of them raises."""
        with ExitStack() as stack:
            for observer in reversed(started):
                stack.callback(observer.run_ended)
            self._tree.halt()

    def _cycle(self, cycle: int) -> bool:
        """Run the root from idle to its end; give False when the run was stopped meanwhile."""
        for observer in self._observers:
            observer.cycle_started(cycle)
        status = NodeStatus.RUNNING
        while status is NodeStatus.RUNNING:
            if self._stop():
                return False
            for look in self._before_tick:
                look()
            status = self._tree.tick()
            self._steps()
        succeeded = status is NodeStatus.SUCCESS
        for observer in self._observers:
            observer.cycle_ended("SUCCESS" if succeeded else "FAILURE", self._reason(status))
        return True

    def _reason(self, status: NodeStatus) -> str:
        if status is NodeStatus.SUCCESS:
            return ""
        if status is NodeStatus.SKIPPED:
            return f"{self._tree.root.name}: the root was skipped, nothing was done"
        return self._tree.failure_reason()

    def _steps(self) -> None:
        """Make the control steps between this tick and the next."""
        cell, after_step = self._cell, self._after_step
        self._note_model()
        for _ in range(self._request.steps_per_tick):
            cell.step()
            for look in after_step:
                look()
        for observer in self._observers:
            observer.after_tick()
        self._pacing.wait(cell.time)

    def _note_model(self) -> None:
        """Tell everyone when the cell was compiled anew."""
        if self._generation != self._cell.generation:
            self._generation = self._cell.generation
            for observer in self._observers:
                observer.model_changed()


def _overridden(name: str, observers: Sequence[RunObserver]) -> tuple[Callable[[], None], ...]:
    """Collect the methods of those observers that do something in them."""
    idle = getattr(RunObserver, name)
    return tuple(getattr(o, name) for o in observers if getattr(type(o), name) is not idle)
