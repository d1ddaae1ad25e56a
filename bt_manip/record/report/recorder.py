"""Record a run and write its report."""

import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from bt_manip.bt.nodes import NodeKind
from bt_manip.record.identification import identify
from bt_manip.record.report.node_log import NodeLog
from bt_manip.record.report.report_file import ReportFile
from bt_manip.record.report.robot_log import RobotLog, combined
from bt_manip.record.report.run_report import (
    CycleReport,
    GrippedObject,
    LeafTime,
    Phase,
    RunReport,
    versions,
)
from bt_manip.runner import Hardware, Run, RunObserver, StepBlock

GRASP = "Grasp"
"""Registered name of the behaviour after which the grip force is measured."""


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

    def leaf_at(self, time: float) -> str:
        """Return the name of the leaf that ran at a time of the cycle [s], the last to start."""
        started = [(start - self._start, str(node.name)) for node, start in self._running.items()]
        started += [(p.start_s, p.name) for p in self._phases if time <= p.start_s + p.duration_s]
        return max((one for one in started if one[0] < time), default=(0.0, ""))[1]

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


@dataclass
class _Gripped:
    """An object that was gripped; `placed` counts once it is removed."""

    name: str
    robot: str = ""
    removed: bool = False
    placed: bool | None = None


class Recorder(RunObserver):
    """Collects the report of a run.

    It changes nothing: a run has the same states with and without a recorder.
    """

    def __init__(self, tree: str, seed: int, *, file: ReportFile | None = None) -> None:
        """Initialise without records.

        Args:
            tree: The tree as the user named it.
            seed: Seed of the run.
            file: Receives the report after each cycle, if given.
        """
        self._tree_name = tree
        self._seed = seed
        self._file = file
        self._identity: dict[str, Any] = {}
        self._digest = b""  # to continue
        self._hardware: Hardware | None = None
        self._cycles: list[CycleReport] = []
        self._unfinished = False
        self._wall_start: float | None = None
        self._wall = 0.0
        self._time_start = self._time_now = 0.0
        self._gripped: list[_Gripped] = []
        self._present: dict[str, _Gripped] = {}  # those of them that have not been removed
        self._unexpected: dict[tuple[str, str], None] = {}  # an ordered set

    # Called by the runner

    def run_started(self, run: Run) -> None:
        """Ask for control steps and digest, and observe the tree."""
        self._run = run
        run.log.keep_digest(self._digest)
        run.log.steps(self._read)
        self._station = station = run.station
        self._cell = station.cell
        self._time_start = self._time_now = self._cell.time
        self._logs = [RobotLog(self._cell, robot) for robot in station.robots.values()]
        self._phases = PhaseLog(lambda: self._cell.time, self._phase_ended)
        self._nodes = NodeLog()
        run.tree.observers += (self._phases, self._nodes)
        self._cell.before_remove.append(self._judge)
        self._begin_cycle()
        self._identity = identify(run)
        self._hardware = run.station.hardware
        self._wall_start = time.perf_counter()
        self._write()

    def cycle_started(self, cycle: int) -> None:
        """Start a cycle."""
        self._begin_cycle()
        self._unfinished = True

    def after_tick(self) -> None:
        """Record the objects that are gripped."""
        cell = self._cell
        self._time_now = cell.time
        held = cell.contact_monitor.summary().held
        # One robot changes nothing about an object that it has gripped already.
        if held and (len(self._logs) > 1 or not self._present.keys() >= set(held)):
            self._note_gripped()

    def cycle_ended(self, status: str, reason: str) -> None:
        """Add the cycle to the report."""
        self._cycles.append(self._cycle(status, reason))
        self._unfinished = False
        self._write()

    def run_ended(self) -> None:
        """Measure the wall time and stop observing the cell."""
        if self._wall_start is None:
            return
        self._time_now = self._cell.time
        self._wall = self._wall_so_far()
        self._cell.before_remove.remove(self._judge)

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
        digest = self._digest if self._wall_start is None else self._run.log.digest
        simulated = round(self._time_now - self._time_start, 6)
        return RunReport(
            tree=self._tree_name,
            seed=self._seed,
            status=status,
            cycles=tuple(cycles),
            simulated_s=simulated,
            wall_s=wall,
            real_time_factor=simulated / wall if wall > 0.0 else 0.0,
            state_digest=(digest or hashlib.sha256().digest()).hex(),
            versions=versions(),
            error=error,
            real={} if self._hardware is None else self._hardware.report,
            **self._identity,
        )

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Continue from the digest in a snapshot of a run; cycles and figures start empty."""
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
        self._nodes.begin()
        self._cycle_start = self._cell.time
        self._gripped, self._present = [], {}
        self._unexpected = {}

    def _read(self, blocks: Mapping[str, StepBlock]) -> None:
        """Evaluate control steps."""
        for log in self._logs:
            log.statistics.update(blocks[log.name])
        block = next(iter(blocks.values()))
        for touch in block.touches:
            if touch.unexpected:
                self._unexpected.update(dict.fromkeys(touch.unexpected))

    def _note_gripped(self) -> None:
        """Record the objects that are gripped now, each until it is removed."""
        for log in self._logs:
            for name in log.gripped():
                one = self._present.get(name)
                if one is None:
                    one = self._present[name] = _Gripped(name)
                    self._gripped.append(one)
                one.robot = log.name

    def _judge(self, name: str) -> None:
        """Judge an object in the step before it is removed."""
        if one := self._present.pop(name, None):
            one.removed, one.placed = True, self._run.goal.placed(name)

    def _phase_ended(self, node: Any, phase: Phase) -> None:
        if phase.behaviour == GRASP:
            name = getattr(node, "robot_name", self._logs[0].name)
            next(log for log in self._logs if log.name == name).grasped()

    def _leaf_times(self, duration: float) -> dict[str, LeafTime]:
        """Return how long the leaves that declare `reports_time` ran in this cycle [s]."""
        nodes = self._run.tree.nodes
        times = {}
        for name in {str(one.registration): None for one in nodes if one.reports_time}:
            phases = [one for one in self._phases.phases if one.behaviour == name]
            spent = sum(one.duration_s for one in phases)
            reasons = dict.fromkeys(one.reason for one in phases if one.status == "FAILURE")
            share = min(spent / duration, 1.0) if duration > 0.0 else 0.0
            times[name] = LeafTime(share, tuple(reasons) if phases else ("it was not ticked",))
        return times

    def _cycle(self, status: str, reason: str) -> CycleReport:
        robots = {log.name: log.cycle(self._phases.leaf_at) for log in self._logs}
        goal = self._run.goal
        objects = tuple(
            GrippedObject(one.name, one.placed if one.removed else goal.placed(one.name), one.robot)
            for one in self._gripped
        )
        placed = [one.placed for one in objects if one.placed is not None]
        ended = status in ("SUCCESS", "FAILURE")
        duration = round(self._cell.time - self._cycle_start, 6)
        judge = "physics" if self._station.hardware.simulated else "gripper and assumption"
        return CycleReport(
            status=status,
            reason=reason,
            goal=goal.holds if ended else None,
            goal_reason=goal.reason if ended else "",
            judged_by=judge if self._run.tree.goal_reads_cell else "tree",
            object=objects[0].name if len(objects) == 1 else None,
            placed=all(placed) if placed else None,
            objects=objects,
            duration_s=duration,
            phases=self._phases.phases,
            unexpected_contacts=tuple(self._unexpected),
            randomized=self._station.randomizer.sampled,
            leaf_times=self._leaf_times(duration),
            drawn=self._nodes.drawn,
            retries=dict(self._nodes.retries),
            rescues=dict(self._nodes.rescues),
            robots=robots if len(robots) > 1 else {},
            **combined(robots.values()),
        )
