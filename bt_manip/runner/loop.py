"""The only loop: ticks, control steps, events, observers and the judge of the goal."""

import contextlib
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, Self

from bt_manip.bt import NodeStatus

from .events import EventStream
from .observer import RunModifier, RunObserver
from .run_log import RunLog

if TYPE_CHECKING:
    from .run import Run

BRAKING = 3.0
"""Longest time to stop the arms when a run is interrupted [s]."""


Stop = Callable[[], bool]
"""Returns whether to stop; called before each tick."""


class CycleEnd(NamedTuple):
    """How a cycle ended: the tree's status, whether its goal holds, too, and why it failed."""

    status: NodeStatus
    succeeded: bool
    reason: str


class Actor(Protocol):
    """Acts at each tick: the tree, an agent in its place, or jogging."""

    def tick(self) -> NodeStatus:
        """Act; return RUNNING until the cycle is to end."""
        ...


class Pacing:
    """Slows simulated time down to wall time; the simulation itself stays the same.

    Args:
        factor: Simulated seconds per second of wall time; None runs as fast as possible.
    """

    def __init__(self, factor: float | None) -> None:
        self.factor = factor
        self._wall = self._simulated = 0.0

    def start(self, simulated: float) -> None:
        """Start at a simulated time [s]."""
        self._wall, self._simulated = time.perf_counter(), simulated

    def wait(self, simulated: float) -> None:
        """Sleep until wall time reaches a simulated time [s]."""
        if self.factor is None:
            return
        due = self._wall + (simulated - self._simulated) / self.factor
        ahead = due - time.perf_counter()
        if ahead > 0.0:
            time.sleep(ahead)
        elif ahead < -1.0:  # more than a second late: do not catch up
            self.start(simulated)


class RunLoop:
    """One execution of a run, advanced from outside: by a cycle, a tick, or control steps.

    A command runs cycles, a step of an environment advances some ticks, a test one::

      with RunLoop(run, observers) as loop:
          loop.cycle()

    On an exception inside, the tree is halted and the arms are stopped, with observers. Of these,
    each `RunModifier` is called after all others; those of the run's request are added.

    Attributes:
        run: The run.
    """

    def __init__(self, run: "Run", observers: Sequence[RunObserver] = ()) -> None:
        self.run = run
        self._station, self._cell = run.station, run.station.cell
        called = [*observers, *run.modifiers]
        self._observers = sorted(called, key=lambda one: isinstance(one, RunModifier))
        self._then: tuple[Callable[[], None], ...] = ()
        self._is_open = False
        self._started: list[RunObserver] = []
        self._cycle: int | None = None
        self._generation: int | None = None
        self._hardware = run.station.hardware
        self._pacing = Pacing(run.request.real_time if self._hardware.simulated else None)
        self._log = run.log = RunLog(run)
        self._events = run.events = EventStream(run)

    # Life

    def __enter__(self) -> Self:
        """Open the loop."""
        try:
            self.open()
        except BaseException as error:
            self.close(failed=isinstance(error, Exception | SystemExit))
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the loop; after an exception halt the tree and stop the arms first."""
        self.close(failed=isinstance(error, Exception | SystemExit))

    def open(self) -> None:
        """Start the observers.

        Raises:
            BtManipError: If one of them cannot observe the run.
        """
        run = self.run
        observed: tuple[list[Any], ...] = run.tree.observers, run.interventions.observers
        self._observers_before = [(observers, list(observers)) for observers in observed]
        self._is_open = True
        for observer in self._observers:
            observer.check(run)
            self._events.listen(observer.handle, observer.kinds)
        for observer in self._observers:
            self._started.append(observer)
            observer.run_started(run)
        self._events.start()
        idle = RunObserver.after_step
        overridden = (o.after_step for o in self._observers if type(o).after_step is not idle)
        self._then = (*self._log.after_step, *overridden)
        self._note_model()
        self._pacing.start(self._cell.time)

    def close(self, *, failed: bool = False) -> None:
        """Halt the tree and end the observers, each of them even if another one raises.

        Args:
            failed: Whether an exception ended the run: then the arms are stopped first.
        """
        if not self._is_open:
            return
        self._is_open = False
        if failed:
            # Further exceptions follow from the first one, which is the one to raise.
            for rescue in (self.run.tree.halt, self._brake):
                with contextlib.suppress(Exception, SystemExit):
                    rescue()
        with ExitStack() as stack:
            stack.callback(self._unobserve)
            while self._started:  # called in the order in which they started
                stack.callback(self._started.pop().run_ended)
            self._log.flush()
            self.run.cycle = 0
            self.run.goal.stop()
            self.run.interventions.clear()
            self.run.tree.halt()

    # A cycle

    def cycle(
        self, number: int = 0, *, in_place: bool = False, stop: Stop = lambda: False
    ) -> CycleEnd | None:
        """Run a cycle; return how it ended, None if it was stopped.

        Args:
            number: Its number, from which its samples follow.
            in_place: As for `begin`; no control steps follow the last tick then, so that a tree
                which ends at once takes no time.
            stop: When it returns True, the tree is halted and the arms are stopped.
        """
        self.begin(number, in_place=in_place)
        last_steps = 0 if in_place else None
        while not stop():
            if (status := self.advance(last_steps=last_steps)) is not NodeStatus.RUNNING:
                return self.end(status)
        self.halt()
        return None

    def begin(self, cycle: int = 0, *, in_place: bool = False) -> None:
        """Begin a cycle, in the cell as it was at the start unless the tree continues.

        Args:
            cycle: Its number, from which its samples follow.
            in_place: Whether the cell stays as it is: it is not randomized, and at the end of the
                cycle the controllers do not return to their defaults.
        """
        self._in_place = in_place
        run = self.run
        if run.start is not None and run.begun and not (in_place or run.tree.continues):
            if not run.tree.is_running:  # else it continues from a state in the middle
                self._station.return_to(run.start)
        run.begun = True
        if not in_place:
            self._station.begin_cycle(cycle)
        self._note_model()
        self._cycle = cycle
        self.run.goal.begin(cycle)
        self._log.flush()
        self._events.begin_cycle(cycle)
        for observer in self._observers:
            observer.cycle_started(cycle)

    def advance(self, actor: Actor | None = None, *, last_steps: int | None = None) -> NodeStatus:
        """Advance by a tick and its control steps; return the status of the actor.

        At the end of a cycle the controllers return to their defaults.

        Args:
            actor: Acts in place of the tree.
            last_steps: Control steps when the actor has ended; None: as many as in a tick.
        """
        status = self.tick(actor)
        if status is NodeStatus.RUNNING:
            self.step()
            return status
        if self._cycle is not None:
            self.run.cycle = self._cycle + 1
            if not self._in_place:
                for robot in self._station.robots.values():
                    robot.controllers.return_to_default()
        self.step(last_steps)
        return status

    def tick(self, actor: Actor | None = None) -> NodeStatus:
        """Let interventions and the actor act; return the actor's status.

        Args:
            actor: Acts in place of the tree.
        """
        for observer in self._observers:
            observer.before_tick()
        self.run.interventions.take_over()
        return (actor or self.run.tree).tick()

    def step(self, steps: int | None = None) -> None:
        """Make the control steps after a tick.

        Args:
            steps: Their number; None: as many as in a tick.
        """
        self._note_model()
        self._control(self.run.request.steps_per_tick if steps is None else steps)
        self._log.after_tick()
        self._events.end_tick()
        for observer in self._observers:
            observer.after_tick()
        self._pacing.wait(self._cell.time)

    def end(self, status: NodeStatus, reason: str | None = None) -> CycleEnd:
        """End a cycle: judge its goal; return how it ended.

        Args:
            status: Status of the actor.
            reason: Why it failed; None: what the tree says.
        """
        self._cycle = None
        if reason is None:
            reason = self._reason(status)
        succeeded, reason = self.run.goal.end(status is NodeStatus.SUCCESS, reason)
        text = "SUCCESS" if succeeded else "FAILURE"
        self._log.flush()
        self._events.end_cycle(text, reason)
        for observer in self._observers:
            observer.cycle_ended(text, reason)
        return CycleEnd(status, succeeded, reason)

    def halt(self) -> None:
        """Halt the tree and stop all arms, with observers."""
        self.run.tree.halt()
        self._brake()

    # Internal

    def _control(self, steps: int) -> None:
        """Make control steps; all steps of all loops are made here."""
        perturbations = self.run.interventions.perturbations
        if perturbations.active:
            for _ in range(steps):
                perturbations.apply()
                self._hardware.step(1, self._then)
        elif steps:
            self._hardware.step(steps, self._then)

    def _brake(self) -> None:
        arms = [robot.arm for robot in self._station.robots.values()]
        for arm in arms:
            if arm.moving:
                arm.stop()
        end = self._cell.time + BRAKING
        while any(arm.moving for arm in arms) and self._cell.time < end:
            self.step()

    def _reason(self, status: NodeStatus) -> str:
        tree = self.run.tree
        if status is NodeStatus.SUCCESS:
            return ""
        if status is NodeStatus.SKIPPED:
            return f"{tree.root.name}: the root was skipped, nothing was done"
        return tree.failure_reason()

    def _unobserve(self) -> None:
        """Remove the observers of tree and interventions that came since the loop was opened."""
        for observers, before in self._observers_before:
            observers[:] = before

    def _note_model(self) -> None:
        """Tell everyone when the cell was compiled anew."""
        if self._generation != self._cell.generation:
            self._generation = self._cell.generation
            self._log.flush()
            self._log.after_compile()
            for observer in self._observers:
                observer.after_compile()
            self._events.after_compile()
