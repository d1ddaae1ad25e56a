"""Watch a run and report it."""

import time
from collections.abc import Mapping
from typing import Any

import numpy as np

from bt_manip.recording.digest import StateDigest
from bt_manip.recording.motion_statistics import MotionStatistics
from bt_manip.recording.phases import PhaseLog
from bt_manip.recording.placement import Placement
from bt_manip.recording.report import CycleReport, Phase, RunReport, versions
from bt_manip.recording.step_log import StepLog
from bt_manip.recording.trace import Trace
from bt_manip.runner.observer import RunObserver

GRASP = "Grasp"
"""Registered name of the behaviour at whose end the grip is measured."""

REMOVE_OBJECT = "RemoveObject"
"""Registered name of the behaviour that a tree which places something ends with."""


class Recorder(RunObserver):
    """Gathers the report of a run, and its trace where one is wanted.

    It only looks: a run with a recorder goes through the same states as one without.
    """

    def __init__(self, tree: str, seed: int, trace: Trace | None = None) -> None:
        """Begin with nothing recorded.

        Args:
            tree: The tree as the user named it.
            seed: Seed of the run.
            trace: Where the course of the joints goes.
        """
        self._tree_name = tree
        self._seed = seed
        self._trace = trace
        self._digest = StateDigest()
        self._cycles: list[CycleReport] = []
        self._unfinished = False
        self._wall_start: float | None = None
        self._wall = 0.0
        self._time_start = self._time_now = 0.0
        self._object: str | None = None
        self._placed: bool | None = None
        self._grip: float | None = None
        self._unexpected: dict[tuple[str, str], None] = {}  # a set that keeps its order

    # What the runner calls

    def run_started(self, run: Any) -> None:
        """Allocate what a step is copied into, and watch the tree."""
        self._run = run
        self._station = station = run.station
        self._cell = station.cell
        self._time_start = self._time_now = self._cell.time
        self._log = StepLog(station)
        self._statistics = MotionStatistics(station.robot.limits, self._cell.dt)
        self._phases = PhaseLog(lambda: self._cell.time)
        self._phases.ended.append(self._phase_ended)
        run.tree.observers.append(self._phases)
        self._places = any(node.registration == REMOVE_OBJECT for node in run.tree.nodes)
        self._placement = Placement(self._cell)
        self._cell.before_remove.append(self._judge)
        self._begin_cycle()
        self._wall_start = time.perf_counter()

    def model_changed(self) -> None:
        """Bind to the new model; note what came and what went."""
        self._flush()
        self._log.bind()
        before = self._placement.objects
        self._placement = Placement(self._cell)
        after = self._placement.objects
        for name in after:
            if before.get(name) is not after[name]:
                self._object, self._placed = name, None

    def cycle_started(self, cycle: int) -> None:
        """Begin a cycle."""
        self._flush()
        self._begin_cycle()
        self._unfinished = True

    def after_step(self) -> None:
        """Copy the state after one control step."""
        if self._log.append():
            self._flush()

    def after_tick(self) -> None:
        """Take the state into the digest."""
        cell = self._cell
        self._time_now = cell.time
        self._digest.update(cell.state_bytes(), self._run.tree.statuses())

    def cycle_ended(self, status: str, reason: str) -> None:
        """Keep the cycle."""
        self._flush()
        self._cycles.append(self._cycle(status, reason))
        self._unfinished = False

    def run_ended(self) -> None:
        """Stop the clock and let go of the tree."""
        if self._wall_start is None:
            return
        self._flush()
        self._time_now = self._cell.time
        self._wall = time.perf_counter() - self._wall_start
        if self._judge in self._cell.before_remove:
            self._cell.before_remove.remove(self._judge)
        if self._phases in self._run.tree.observers:
            self._run.tree.observers.remove(self._phases)

    # What others ask

    def report(self, status: str | None = None, error: str = "") -> RunReport:
        """Put together what there is.

        Args:
            status: How the run ended, when not by its last cycle: ``"INTERRUPTED"`` or
                ``"ERROR"``.
            error: What ended it, for ``"ERROR"``.
        """
        cycles = list(self._cycles)
        if self._unfinished and status is not None:
            cycles.append(self._cycle(status, error))
        if status is None:
            failed = any(cycle.status != "SUCCESS" for cycle in cycles)
            status = "FAILURE" if failed else "SUCCESS"
        simulated = round(self._time_now - self._time_start, 6)
        return RunReport(
            tree=self._tree_name,
            seed=self._seed,
            status=status,
            cycles=tuple(cycles),
            simulated_s=simulated,
            wall_s=self._wall,
            real_time_factor=simulated / self._wall if self._wall > 0.0 else 0.0,
            state_digest=self._digest.hexdigest(),
            versions=versions(),
            error=error,
        )

    # Going on with a run that was taken up from a snapshot

    def get_state(self) -> dict[str, Any]:
        """Give as plain data what a report of the rest of the run builds on: the digest so far."""
        return {"digest": self._digest.get_state()}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Go on from the digest of another recorder; cycles and figures begin anew."""
        self._digest.set_state(state["digest"])

    # Inside

    def _begin_cycle(self) -> None:
        self._statistics.begin()
        self._phases.begin()
        self._cycle_start = self._cell.time
        self._object = None
        self._placed = None
        self._grip = None
        self._unexpected = {}
        self._saturated_before = self._station.controller.saturated_steps

    def _flush(self) -> None:
        """Evaluate the steps that have gathered."""
        block = self._log.take()
        if not block.touches:
            return
        self._statistics.update(
            q=block.q, q_ref=block.q_ref, v_ref=block.v_ref, a_ref=block.a_ref, tau=block.tau,
            tool=block.tool,
            free=np.fromiter((touch.free for touch in block.touches), bool, len(block.touches)),
        )  # fmt: skip
        for touch in block.touches:
            if touch.unexpected:
                self._unexpected.update(dict.fromkeys(touch.unexpected))
            if self._object is None and touch.held:
                self._object = touch.held[0]
        if self._trace is not None:
            self._trace.append(
                block.t,
                (block.q, block.v, block.q_ref, block.v_ref, block.a_ref, block.tau),
            )

    def _judge(self, name: str) -> None:
        """Judge the object of the cycle in the step before it is taken out."""
        if name == self._object:
            self._placed = self._is_placed(name)

    def _is_placed(self, name: str) -> bool:
        return name in self._placement.objects and self._placement.placed(name)

    def _phase_ended(self, node: Any, phase: Phase) -> None:
        if phase.behaviour == GRASP and phase.status == "SUCCESS":
            self._grip = float(min(self._station.gripper.finger_forces))

    def _cycle(self, status: str, reason: str) -> CycleReport:
        placed = self._placed
        if self._places and placed is None:
            # It was never removed: it counts where it is.
            placed = self._object is not None and self._is_placed(self._object)
        return CycleReport(
            status=status,
            reason=reason,
            object=self._object,
            placed=placed,
            duration_s=round(self._cell.time - self._cycle_start, 6),
            phases=self._phases.phases,
            grip_force_n=self._grip,
            max_tracking_error_rad=self._statistics.tracking_error,
            limits=self._statistics.limit_use,
            saturated_steps=self._station.controller.saturated_steps - self._saturated_before,
            unexpected_contacts=tuple(self._unexpected),
            max_torque_rate_nm_s=self._statistics.torque_rate,
            max_tool_speed_m_s=self._statistics.tool_speed,
            randomized=self._station.randomizer.drawn,
        )
