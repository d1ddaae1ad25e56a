"""Record a run and write its report."""

import hashlib
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from bt_manip.bt.nodes import NodeKind
from bt_manip.cell import why_not_in_any
from bt_manip.recording.identification import identify
from bt_manip.recording.report import CycleReport, Phase, RunReport, versions
from bt_manip.recording.report_file import ReportFile
from bt_manip.recording.robot_log import RobotLog, combined
from bt_manip.recording.trace import Trace, columns_of
from bt_manip.runner import RunObserver

GRASP = "Grasp"
"""Registered name of the behaviour after which the grip force is measured."""

REMOVE_OBJECT = "RemoveObject"
"""Registered name of the behaviour that ends a tree that places an object."""


def next_digest(digest: bytes, state: bytes, statuses: bytes) -> bytes:
    """Return the SHA-256 digest of the previous digest, the state and the statuses.

    The state is MuJoCo's integration state, on which the next step depends. Two runs with the same
    digest have the same states, bit for bit.

    Args:
        digest: The digest after the previous tick; empty at the first.
        state: The integration state, as returned by `bt_manip.cell.Cell.state_bytes`.
        statuses: One byte for each node of the tree.
    """
    return hashlib.sha256(digest + state + statuses).digest()


class PhaseLog:
    """Tree observer that records the action leaves, in the order in which they end."""

    def __init__(self, clock: Callable[[], float], ended: Callable[[Any, Phase], None]) -> None:
        """Initialise without phases.

        Args:
            clock: Returns the simulated time [s].
            ended: Called with node and phase when an action leaf has ended.
        """
        self._clock, self._ended = clock, ended
        self.begin()

    def begin(self) -> None:
        """Begin a cycle."""
        self._start = self._clock()
        self._running: dict[Any, float] = {}
        self._phases: list[Phase] = []

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Phases that have ended in this cycle."""
        return tuple(self._phases)

    def __call__(self, node: Any, old: Any, new: Any) -> None:
        """Record a change of a node's status."""
        if node.kind is not NodeKind.ACTION:
            return
        if new.name == "RUNNING":
            self._running.setdefault(node, self._clock())
        elif new.name in ("SUCCESS", "FAILURE"):
            self._end(node, new.name, self._running.pop(node, self._clock()))
        elif node in self._running:
            self._end(node, "HALTED", self._running.pop(node))

    def _end(self, node: Any, status: str, start: float) -> None:
        phase = Phase(
            behaviour=str(node.registration),
            name=str(node.name),
            status=status,
            reason="" if status == "SUCCESS" else str(node.feedback_message),
            start_s=_seconds(start - self._start),
            duration_s=_seconds(self._clock() - start),
        )
        self._phases.append(phase)
        self._ended(node, phase)


def _seconds(duration: float) -> float:
    """Round to microseconds: sums of control steps of 1 ms have rounding errors."""
    return round(duration, 6)


class Recorder(RunObserver):
    """Collects the report of a run, and optionally its trace.

    It changes nothing: a run has the same states with and without a recorder.
    """

    def __init__(
        self,
        tree: str,
        seed: int,
        trace: Trace | None = None,
        *,
        file: ReportFile | None = None,
        plugins: Mapping[str, str] | None = None,
    ) -> None:
        """Initialise without records.

        Args:
            tree: The tree as the user named it.
            seed: Seed of the run.
            trace: Receives every control step, if given.
            file: Receives the report after each cycle, if given.
            plugins: Versions of the loaded plugins, by name.
        """
        self._tree_name = tree
        self._seed = seed
        self._trace = trace
        self._file = file
        self._identity: dict[str, Any] = {"plugins": dict(plugins or {})}
        self._digest = b""
        self._cycles: list[CycleReport] = []
        self._unfinished = False
        self._wall_start: float | None = None
        self._wall = 0.0
        self._time_start = self._time_now = 0.0
        self._object: str | None = None
        self._judged: dict[str, bool] = {}
        self._unexpected: dict[tuple[str, str], None] = {}  # an ordered set

    # Called by the runner

    def run_started(self, run: Any) -> None:
        """Allocate the step logs and observe the tree."""
        self._run = run
        self._station = station = run.station
        self._cell = station.cell
        self._time_start = self._time_now = self._cell.time
        self._logs = [RobotLog(self._cell, robot) for robot in station.robots.values()]
        self._phases = PhaseLog(lambda: self._cell.time, self._phase_ended)
        run.tree.observers.append(self._phases)
        self._places = any(node.registration == REMOVE_OBJECT for node in run.tree.nodes)
        self._objects = self._free_objects()
        self._cell.before_remove.append(self._judge)
        self._begin_cycle()
        self._identity.update(identify(run))
        self._wall_start = time.perf_counter()
        self._write()

    def after_compile(self) -> None:
        """Bind to the new model; record added objects."""
        self._flush()
        for log in self._logs:
            log.steps.bind()
        before = self._objects
        self._objects = after = self._free_objects()
        for name in after:
            if before.get(name) is not after[name]:
                self._object = name
                self._judged.pop(name, None)

    def cycle_started(self, cycle: int) -> None:
        """Start a cycle."""
        self._flush()
        self._begin_cycle()
        self._unfinished = True

    def after_step(self) -> None:
        """Copy the state after one control step."""
        full = False
        for log in self._logs:
            full = log.steps.append()
        if full:
            self._flush()

    def after_tick(self) -> None:
        """Add the state to the digest."""
        cell = self._cell
        self._time_now = cell.time
        self._digest = next_digest(self._digest, cell.state_bytes(), self._run.tree.statuses())

    def cycle_ended(self, status: str, reason: str) -> None:
        """Add the cycle to the report."""
        self._flush()
        self._cycles.append(self._cycle(status, reason))
        self._unfinished = False
        self._write()

    def run_ended(self) -> None:
        """Measure the wall time and stop observing the tree."""
        if self._wall_start is None:
            return
        self._flush()
        self._time_now = self._cell.time
        self._wall = self._wall_so_far()
        if self._judge in self._cell.before_remove:
            self._cell.before_remove.remove(self._judge)
        if self._phases in self._run.tree.observers:
            self._run.tree.observers.remove(self._phases)

    # Results

    def report(self, status: str | None = None, error: str = "") -> RunReport:
        """Return the report of the run so far.

        Args:
            status: Status of a run that did not end with its last cycle: ``"INTERRUPTED"``,
                ``"ERROR"`` or ``"RUNNING"``.
            error: Reason, for ``"ERROR"``.
        """
        cycles = list(self._cycles)
        if self._unfinished and status is not None:
            cycles.append(self._cycle(status, error))
        if status is None:
            failed = any(cycle.status != "SUCCESS" for cycle in cycles)
            status = "FAILURE" if failed else "SUCCESS"
        wall = self._wall or self._wall_so_far()
        simulated = round(self._time_now - self._time_start, 6)
        return RunReport(
            tree=self._tree_name,
            seed=self._seed,
            status=status,
            cycles=tuple(cycles),
            simulated_s=simulated,
            wall_s=wall,
            real_time_factor=simulated / wall if wall > 0.0 else 0.0,
            state_digest=(self._digest or hashlib.sha256().digest()).hex(),
            versions=versions(),
            error=error,
            **self._identity,
        )

    # Continuing a run from a snapshot

    def get_state(self) -> dict[str, Any]:
        """Return the digest so far, as plain data."""
        return {"digest": self._digest.hex()}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Continue from the digest of another recorder; cycles and figures start empty."""
        self._digest = bytes.fromhex(state["digest"])

    # Internal

    def _write(self) -> None:
        if self._file is not None:
            self._file.update(self.report("RUNNING"))

    def _wall_so_far(self) -> float:
        return 0.0 if self._wall_start is None else time.perf_counter() - self._wall_start

    def _begin_cycle(self) -> None:
        for log in self._logs:
            log.begin()
        self._phases.begin()
        self._cycle_start = self._cell.time
        self._object = None
        self._judged = {}
        self._unexpected = {}

    def _flush(self) -> None:
        """Evaluate the recorded steps."""
        blocks = {log.name: log.take() for log in self._logs}
        block = next(iter(blocks.values()))
        if not block.touches:
            return
        for touch in block.touches:
            if touch.unexpected:
                self._unexpected.update(dict.fromkeys(touch.unexpected))
            if self._object is None and touch.held:
                self._object = touch.held[0]
        if self._trace is not None:
            self._trace.append(block.t, *columns_of(blocks))

    def _judge(self, name: str) -> None:
        """Check an object in the step before it is removed."""
        self._judged[name] = self._is_placed(name)

    def _is_placed(self, name: str) -> bool:
        return name in self._objects and not why_not_in_any(self._cell, name)

    def _free_objects(self) -> dict[str, Any]:
        objects = self._cell.objects.items()
        return {name: entity for name, entity in objects if self._cell.is_free(name)}

    def _phase_ended(self, node: Any, phase: Phase) -> None:
        if phase.behaviour == GRASP and phase.status == "SUCCESS":
            name = getattr(node, "robot_name", self._logs[0].name)
            next(log for log in self._logs if log.name == name).grasped()

    def _placed(self, names: Sequence[str]) -> bool | None:
        """Return whether all objects of the cycle are placed; None if nothing is to be placed."""
        judged = [self._judged.get(name) for name in names]
        if self._places:  # objects that were not removed are checked now
            return bool(names) and all(
                self._is_placed(name) if known is None else known
                for name, known in zip(names, judged, strict=True)
            )
        return None if not names or None in judged else all(judged)

    def _cycle(self, status: str, reason: str) -> CycleReport:
        robots = {log.name: log.cycle() for log in self._logs}
        several = len(robots) > 1
        if several:
            handled = [name for robot in robots.values() for name in robot.picked]
        else:
            handled = [] if self._object is None else [self._object]
        return CycleReport(
            status=status,
            reason=reason,
            object=None if several else self._object,
            placed=self._placed(handled),
            duration_s=round(self._cell.time - self._cycle_start, 6),
            phases=self._phases.phases,
            unexpected_contacts=tuple(self._unexpected),
            randomized=self._station.randomizer.sampled,
            robots=robots if several else {},
            **combined(robots.values()),
        )
