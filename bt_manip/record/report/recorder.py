"""Record a run and write its report."""

import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import fields
from functools import partial
from typing import Any

from bt_manip.record.figures import RobotFigures, RunFigures, live_state
from bt_manip.record.identification import identify
from bt_manip.record.report.node_log import NodeLog
from bt_manip.record.report.report_file import ReportFile
from bt_manip.record.report.run_report import (
    CycleReport,
    GrippedObject,
    LeafTime,
    RunReport,
    versions,
)
from bt_manip.runner import Hardware, Run, RunEvent, RunObserver, StepBlock


class Recorder(RunObserver):
    """Collects the report of a run.

    It changes nothing: a run has the same states with and without a recorder.

    Args:
        tree: The tree as the user named it.
        seed: Seed of the run.
        file: Receives the report after each cycle, if given.
    """

    kinds = RunFigures.kinds

    def __init__(self, tree: str, seed: int, *, file: ReportFile | None = None) -> None:
        self._tree_name = tree
        self._seed = seed
        self._file = file
        self._identify: Callable[[], dict[str, Any]] = dict
        self._digest = b""  # to continue
        self._hardware: Hardware | None = None
        self._cycles: list[CycleReport] = []
        self._unfinished = False
        self._wall_start: float | None = None
        self._wall = 0.0
        self._time_start = self._time_now = 0.0
        self._unexpected: dict[tuple[str, str], None] = {}  # an ordered set

    @property
    def began(self) -> bool:
        """Whether a cycle has begun."""
        return self._unfinished or bool(self._cycles)

    # Called by the runner

    def run_started(self, run: Run) -> None:
        """Ask for control steps and digest, and observe the tree."""
        self._run, self._identify = run, partial(identify, run)
        run.log.keep_digest(self._digest)
        run.log.steps(self._read)
        self._station = station = run.station
        self._cell = cell = station.cell
        self._time_start = self._time_now = cell.time
        robots = {
            name: RobotFigures(
                one.robot.description.arm_joints,
                one.robot.limits,
                cell.dt,
                partial(live_state, cell, one),
            )  # fmt: skip
            for name, one in station.robots.items()
        }
        self._figures = RunFigures(robots, cell.time)
        self._nodes = NodeLog()
        run.tree.observers.append(self._nodes)
        self._hardware = station.hardware
        self._wall_start = time.perf_counter()
        self._write()

    def cycle_started(self, cycle: int) -> None:
        """Start a cycle."""
        self._nodes.begin()
        self._unexpected = {}
        self._unfinished = True

    def handle(self, event: RunEvent) -> None:
        """Add an event to the figures."""
        self._figures.handle(event)

    def after_tick(self) -> None:
        """Record the objects that are gripped."""
        self._time_now = self._cell.time
        for robot, figures in self._figures.robots.items():
            for name in figures.gripped():
                self._run.goal.grip(name, robot)

    def cycle_ended(self, status: str, reason: str) -> None:
        """Add the cycle to the report."""
        self._cycles.append(self._cycle(status, reason))
        self._unfinished = False
        self._write()

    def run_ended(self) -> None:
        """Measure the wall time."""
        if self._wall_start is None:
            return
        self._time_now = self._cell.time
        self._wall = self._wall_so_far()

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
            ended_early="" if self._wall_start is None else self._run.ended_early,
            warnings=() if self._wall_start is None else tuple(self._run.station.model_warnings()),
            real={} if self._hardware is None else self._hardware.report,
            **self._identify(),
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

    def _read(self, blocks: Mapping[str, StepBlock]) -> None:
        """Evaluate control steps."""
        for name, block in blocks.items():
            self._figures.robots[name].update(block)
        for touch in block.touches:  # those of the cell: the same for all robots
            if touch.unexpected:
                self._unexpected.update(dict.fromkeys(touch.unexpected))

    def _leaf_times(self, duration: float) -> dict[str, LeafTime]:
        """Return how long the leaves that declare `reports_time` ran in this cycle [s]."""
        nodes = self._run.tree.nodes
        times = {}
        for name in {str(node.registration): None for node in nodes if node.reports_time}:
            phases = [phase for phase in self._figures.phases if phase.behaviour == name]
            spent = sum(phase.duration_s for phase in phases)
            reasons = dict.fromkeys(phase.reason for phase in phases if phase.status == "FAILURE")
            share = min(spent / duration, 1.0) if duration > 0.0 else 0.0
            times[name] = LeafTime(share, tuple(reasons) if phases else ("it was not ticked",))
        return times

    def _cycle(self, status: str, reason: str) -> CycleReport:
        figures = self._figures.cycle(self._cell.time)
        known = {f.name for f in fields(CycleReport)} - {"status", "reason", "robots"}
        goal = self._run.goal
        objects = tuple(
            GrippedObject(one.name, one.placed if one.removed else goal.placed(one.name), one.robot)
            for one in goal.gripped
        )
        placed = [one.placed for one in objects if one.placed is not None]
        ended = status in ("SUCCESS", "FAILURE")
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
            duration_s=figures.duration_s,
            unexpected_contacts=tuple(self._unexpected),
            randomized=self._station.randomizer.sampled,
            leaf_times=self._leaf_times(figures.duration_s),
            drawn=self._nodes.drawn,
            retries=dict(self._nodes.retries),
            rescues=dict(self._nodes.rescues),
            results={k: _plain(v) for k, v in self._run.tree.result_values().items()},
            robots=figures.robots if len(figures.robots) > 1 else {},
            **{name: value for name, value in vars(figures).items() if name in known},
        )


def _plain(value: Any) -> Any:
    """Return the value of an entry as JSON has it, or as text."""
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value if value is None or isinstance(value, bool | int | float | str) else str(value)
