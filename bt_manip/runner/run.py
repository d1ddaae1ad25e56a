"""The loop of a run: ticks of the tree, control steps of the cell, calls of the observers."""

import contextlib
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.bt import NodeStatus, Tree
from bt_manip.notebook import html_table

from .goal import GoalJudge
from .interventions import Interventions
from .observer import RunObserver
from .request import RunRequest

if TYPE_CHECKING:
    from .station import Station

Stop = Callable[[], bool]

BRAKING = 3.0
"""Longest time to stop the arms when a run is interrupted [s]."""


@dataclass(eq=False)
class Run:
    """A tree that is ready to run, or to continue, in a station.

    Attributes:
        cycle: The present cycle, or the next one.
        goal: Judges the tree's goal; it has judged a cycle when `cycle_ended` is called.
        identity: What identifies the run besides its request, by the fields of its report:
            ``plugins``, ``faults``, ``foreign``.
        interventions: Takes requests to pull bodies and to set the statuses of nodes.
        observers: Those of the present or last execution.
        stop: Returns whether the run has to end; whoever pauses it checks this often.
        reporters: Called with kind and data of each event that an observer adds by `report`.
    """

    request: RunRequest
    tree: Tree
    station: "Station"
    cycle: int = 0
    identity: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Prepare to judge the tree's goal."""
        self.goal = GoalJudge(self.tree, self.station.cell)
        self.interventions = Interventions(self.tree, self.station)
        self.observers: Sequence[RunObserver] = ()
        self.stop: Stop = lambda: False
        self.reporters: list[Callable[[str, dict[str, Any]], None]] = []
        self._initial: dict[str, Any] | None = None

    def _repr_html_(self) -> str:
        """Show the request, the present cycle and the tree in a notebook."""
        request, cell = self.request, self.station.cell
        rows = {
            "tree": request.tree.name,
            "robots": ", ".join(self.station.robots),
            "scene": request.scene,
            "seed": request.seed,
            "cycle": f"{self.cycle + 1} of {request.cycles or 'any number'}",
            "time": f"{cell.time:.2f} s",
        }
        return html_table("Run", rows) + self.tree._repr_svg_()

    def execute(self, observers: Sequence[RunObserver] = (), *, stop: Stop = lambda: False) -> None:
        """Run the requested cycles.

        Args:
            observers: Called as `RunObserver` documents.
            stop: Called once per tick; when it returns True, the tree is halted, the arms are
                stopped and the run ends.

        Raises:
            Exception: Any exception of a behaviour, a controller or an observer, after `run_ended`
                has been called for all observers.
        """
        self.stop = stop
        RunLoop(self, observers).run()

    def begin_episode(self, episode: int, seed: int | None = None) -> None:
        """Return to the initial state, from which `execute` then runs one episode.

        An episode is one run of the root. It depends only on the request and on its number, from
        which the samples and the state of the station's random generator follow, not on what ran
        before; so it is the same in any process, bit for bit.

        Args:
            episode: Its number, which is also that of its cycle.
            seed: Another seed for the request; None: the present one.

        Raises:
            CellError: If an object of the scene finds no free pose with this seed.
        """
        if self._initial is None:
            self._initial = self.get_state()
        self.set_state(self._initial)
        if seed is not None:
            self.request = replace(self.request, seed=seed)
        self.station.reseed(self.request.seed)
        rng = np.random.default_rng((self.request.seed, episode))
        self.station.rng.bit_generator.state = rng.bit_generator.state
        self.request = replace(self.request, cycles=episode + 1)
        self.cycle = episode

    def report(self, kind: str, data: dict[str, Any]) -> None:
        """Add an event to all event streams; `RunEvent` documents kinds and data."""
        for reporter in tuple(self.reporters):
            reporter(kind, data)

    def get_state(self) -> dict[str, Any]:
        """Return the state of the run as plain data.

        Taken between two ticks, as in an observer's `after_tick`, it can be continued by another
        run of the same request, also in another process.
        """
        return {
            "cycle": self.cycle,
            "station": self.station.get_state(),
            "tree": self.tree.get_state(),
            "goal": self.goal.get_state(),
            "interventions": self.interventions.get_state(),
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`; `execute` continues from there bit for bit.

        Raises:
            BtManipError: If the state is of another tree, or has objects that are not known here.
        """
        self.station.set_state(state["station"])
        self.tree.set_state(state["tree"])
        self.goal.set_state(state["goal"])
        self.interventions.set_state(state.get("interventions", {"pulls": ()}))
        self.cycle = state["cycle"]


class RunLoop:
    """One execution of a run: ticks of the tree, control steps, calls of the observers."""

    def __init__(self, run: Run, observers: Sequence[RunObserver]) -> None:
        """Prepare to call the observers."""
        run.observers = observers
        self._tree, self._cell = run.tree, run.station.cell
        self._run, self._request = run, run.request
        self._interventions = run.interventions
        self._observers = observers
        self._before_tick = _overridden("before_tick", observers)
        self._after_step = _overridden("after_step", observers)
        self._generation: int | None = None
        self._pacing = Pacing(run.request.real_time)

    def run(self) -> None:
        """Run the requested cycles, and halt the tree."""
        with self.observed(self._tree.halt):
            self._pacing.start(self._cell.time)
            run = self._run
            while self._request.cycles == 0 or run.cycle < self._request.cycles:
                if not self._cycle(run.cycle):
                    self._tree.halt()
                    self._brake()
                    break

    @contextlib.contextmanager
    def observed(self, end: Callable[[], object] = lambda: None) -> Iterator[None]:
        """Call the observers; on an exception inside, halt the tree and stop the arms.

        Args:
            end: Called before `run_ended` of the observers.
        """
        started: list[RunObserver] = []
        try:
            for observer in self._observers:
                observer.check(self._run)
            for observer in self._observers:
                started.append(observer)
                observer.run_started(self._run)
            self._note_model()
            yield
        except (Exception, SystemExit):
            # Further exceptions follow from the first one, which is the one to raise.
            for rescue in (self._tree.halt, self._brake):
                with contextlib.suppress(Exception, SystemExit):
                    rescue()
            raise
        finally:
            with ExitStack() as stack:  # every observer ends, even if one raises
                for observer in reversed(started):
                    stack.callback(observer.run_ended)
                self._run.cycle = 0
                self._run.goal.stop()
                self._interventions.clear()
                end()

    def _brake(self) -> None:
        """Stop all arms, with observers."""
        arms = [robot.arm for robot in self._run.station.robots.values()]
        for arm in arms:
            if arm.moving:
                arm.stop()
        end = self._cell.time + BRAKING
        while any(arm.moving for arm in arms) and self._cell.time < end:
            self.step(self._request.steps_per_tick)

    def _cycle(self, cycle: int) -> bool:
        """Run the root from idle to its end; return False if the run was stopped meanwhile."""
        self._run.station.randomizer.begin(cycle)
        self.begin_cycle(cycle)
        status = NodeStatus.RUNNING
        while status is NodeStatus.RUNNING:
            if self._run.stop():
                return False
            status = self.tick()
            if status is not NodeStatus.RUNNING:
                self._run.cycle = cycle + 1
                for robot in self._run.station.robots.values():
                    robot.controllers.return_to_default()
            self.step(self._request.steps_per_tick)
        self.end_cycle(status)
        return True

    def begin_cycle(self, cycle: int = 0) -> None:
        """Begin to judge the goal in a cycle."""
        self._note_model()
        self._run.goal.begin(cycle)
        for observer in self._observers:
            observer.cycle_started(cycle)

    def end_cycle(self, status: NodeStatus) -> tuple[bool, str]:
        """Return whether a cycle succeeded, given the status of its tree, and why not."""
        succeeded, reason = self._run.goal.end(status is NodeStatus.SUCCESS, self._reason(status))
        for observer in self._observers:
            observer.cycle_ended("SUCCESS" if succeeded else "FAILURE", reason)
        return succeeded, reason

    def _reason(self, status: NodeStatus) -> str:
        if status is NodeStatus.SUCCESS:
            return ""
        if status is NodeStatus.SKIPPED:
            return f"{self._tree.root.name}: the root was skipped, nothing was done"
        return self._tree.failure_reason()

    def tick(self) -> NodeStatus:
        """Tick the tree and return its status."""
        for observe in self._before_tick:
            observe()
        self._interventions.take_over()
        return self._tree.tick()

    def step(self, steps: int) -> None:
        """Make control steps after a tick."""
        cell = self._cell
        self._note_model()
        if self._interventions.pulling:
            for _ in range(steps):
                self._interventions.apply()
                cell.step(then=self._after_step)
        elif steps:
            cell.step(steps, then=self._after_step)
        for observer in self._observers:
            observer.after_tick()
        self._pacing.wait(cell.time)

    def _note_model(self) -> None:
        """Tell everyone when the cell was compiled anew."""
        if self._generation != self._cell.generation:
            self._generation = self._cell.generation
            for observer in self._observers:
                observer.after_compile()


def _overridden(name: str, observers: Sequence[RunObserver]) -> tuple[Callable[[], None], ...]:
    """Return the overridden methods of this name."""
    idle = getattr(RunObserver, name)
    return tuple(getattr(o, name) for o in observers if getattr(type(o), name) is not idle)


class Pacing:
    """Slows simulated time down to wall time; the simulation itself stays the same."""

    def __init__(self, factor: float | None) -> None:
        """Set the real-time factor.

        Args:
            factor: Simulated seconds per second of wall time; None runs as fast as possible.
        """
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
