"""Figures of a run, from its events, control steps and states of robots, live or recorded.

The report of a run feeds them while it goes on, the reader of its recording from the file.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, field
from typing import Any, NamedTuple

import numpy as np

from bt_manip.bt.nodes import NodeKind
from bt_manip.record.report.run_report import CycleLimitUse, Phase, RobotCycle, TrackingPeak
from bt_manip.robots import MotionLimits
from bt_manip.runner import RunEvent, RunObserver, StepBlock

GRASP = "Grasp"
"""Registered name of the behaviour after which the grip force is measured."""


BEFORE_PEAK = 0.1
"""Time before a tracking error in which its cause is looked for: four time constants of the
computed torque controller's default poles [s]."""


class Interval(NamedTuple):
    """Time in which a node ran or two bodies touched; both ends are equal where it took no time."""

    start: float
    """Simulated time [s]."""
    end: float
    """Simulated time [s]."""
    status: str
    """Final status, ``"HALTED"``, or ``"RUNNING"`` if the recording ends before."""
    reason: str = ""
    """Reason of a failure, or the last message of a node that was halted."""


@dataclass(frozen=True)
class LoggedNode:
    """A node of a tree, as the event ``tree`` describes it.

    Attributes:
        key: Its path, with its uid where another node has the same path.
        depth: Number of nodes above it.
        intervals: Its executions in a recording, in the order of their ends; empty in a live run.
    """

    uid: int
    key: str
    name: str
    path: str
    kind: str
    registration: str
    depth: int
    is_leaf: bool
    intervals: list[Interval] = field(default_factory=list, repr=False, compare=False)


class ExecutionLog(RunObserver):
    """Executions of nodes from their start to their end.

    Args:
        ended: Called with node and interval when a node has ended, and with the name of the robot
            that it used; empty without one.

    Attributes:
        nodes: The nodes of the present tree, by uid.
        running: Start of each node that runs [s], by uid, in the order of the starts.
    """

    kinds = ("tree", "status")

    def __init__(self, ended: Callable[[LoggedNode, Interval, str], None]) -> None:
        self._ended = ended
        self.nodes: dict[int, LoggedNode] = {}
        self.running: dict[int, float] = {}

    def handle(self, event: RunEvent) -> None:
        """Take an event of the run."""
        data = event.data
        if event.kind == "tree":
            self.end(event.time, "HALTED")
            self.nodes = _nodes(data["nodes"])
        elif event.kind == "status":
            uid, status = data["uid"], data["status"]
            start = self.running.pop(uid, None)
            if status == "RUNNING":
                self.running[uid] = event.time if start is None else start
            elif start is not None or status in ("SUCCESS", "FAILURE"):
                start = event.time if start is None else start
                ended = "HALTED" if status == "IDLE" else status
                reason = data["reason"] or data.get("message", "")
                interval = Interval(start, event.time, ended, reason)
                self._ended(self.nodes[uid], interval, data.get("robot", ""))

    def end(self, time: float, status: str) -> None:
        """End the executions of all nodes that run, at a simulated time [s]."""
        for uid, start in self.running.items():
            self._ended(self.nodes[uid], Interval(start, time, status), "")
        self.running.clear()

    @property
    def running_leaves(self) -> tuple[LoggedNode, ...]:
        """The leaves that run, in the order of their starts."""
        return tuple(n for uid in self.running if (n := self.nodes[uid]).is_leaf)


def _nodes(described: Sequence[Mapping[str, Any]]) -> dict[int, LoggedNode]:
    nodes: dict[int, LoggedNode] = {}
    parents, keys = {one["parent"] for one in described}, set()
    for one in described:
        uid, path, above = one["uid"], one["path"], nodes.get(one["parent"])
        key = f"{path}::{uid}" if path in keys else path
        keys.add(key)
        depth = 0 if above is None else above.depth + 1
        about = one["name"], path, one["kind"], one["registration"]
        nodes[uid] = LoggedNode(uid, key, *about, depth, uid not in parents)
    return nodes


def limit_use(
    limits: MotionLimits,
    q_ref: np.ndarray,
    v_ref: np.ndarray,
    a_ref: np.ndarray,
    jerk: np.ndarray,
    tau: np.ndarray,
) -> np.ndarray:
    """Return the largest fraction of each kind of limit that a joint uses in each control step.

    Args:
        limits: Limits that the fractions refer to.
        q_ref: Reference position [rad].  # (n, nq), as all others
        v_ref: Reference velocity [rad/s].
        a_ref: Reference acceleration [rad/s2].
        jerk: Reference jerk [rad/s3].
        tau: Torque [N m].

    Returns:
        A column for each field of `CycleLimitUse`.  # (n, 5)
    """
    # A joint without bounds has no use of its range.
    half_range = (limits.upper - limits.lower) / 2.0
    bounded = np.isfinite(half_range)
    centre = np.add(limits.upper, limits.lower, where=bounded, out=np.zeros_like(limits.upper))
    used = (
        (q_ref - centre / 2.0, np.where(bounded, half_range, np.inf)),
        (v_ref, limits.velocity_at(q_ref, v_ref)),
        (a_ref, limits.acceleration),
        (jerk, limits.jerk),
        (tau, limits.effort),
    )
    return np.stack([np.abs(x / most).max(axis=1) for x, most in used], axis=1)


class Peak(NamedTuple):
    """The largest tracking error, as in `TrackingPeak`."""

    error: float  # [rad]
    joint: int  # from 0
    time: float  # [s] simulated
    effort: float  # largest use before
    after_contact: float | None  # time since the last contact [s]


class StepFigures(NamedTuple):
    """Figures of each control step of a block."""

    error: np.ndarray
    """Tracking error: position minus reference [rad].  # (n, nq)"""
    free: np.ndarray
    """Whether it moved, grippers and the entities they hold touching only each other.  # (n,)"""
    use: np.ndarray
    """Largest fraction of each kind of limit, as in `CycleLimitUse`.  # (n, 5)"""


class MotionStatistics:
    """Maxima over control steps, updated in blocks of steps of any length.

    Differences between steps (jerk, torque rate, tool speed) are also taken between blocks and
    between cycles.
    """

    def __init__(self, limits: MotionLimits, dt: float) -> None:
        self._limits = limits
        self._dt = dt
        self._last: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self._recent = np.zeros((round(BEFORE_PEAK / dt), 2))  # use of effort, whether it touched
        self.begin()

    def begin(self) -> None:
        """Reset the maxima; the last step is kept for differences."""
        self._use = np.zeros(5)  # position, velocity, acceleration, jerk, effort
        self.torque_rate = 0.0  # [N m/s]
        self.tool_speed = 0.0  # [m/s]
        self.peak: Peak | None = None
        self.deflection = 0.0  # [rad]

    def update(self, block: StepBlock) -> StepFigures:
        """Update the maxima with control steps, at least one, and return the figures of each."""
        a_ref, tau, tool = block.a_ref, block.tau, block.tool
        if self._last is None:
            self._last = (a_ref[0], tau[0], tool[0])
        jerk, torque_rate, velocity = (
            np.diff(rows, axis=0, prepend=last[None]) / self._dt
            for rows, last in zip((a_ref, tau, tool), self._last, strict=True)
        )
        self._last = (a_ref[-1].copy(), tau[-1].copy(), tool[-1].copy())
        use = limit_use(self._limits, block.q_ref, block.v_ref, a_ref, jerk, tau)
        self._use = np.maximum(self._use, use.max(axis=0))
        self.torque_rate = max(self.torque_rate, float(np.abs(torque_rate).max()))
        speed = np.linalg.norm(velocity, axis=1).max()
        self.tool_speed = float(np.maximum(self.tool_speed, speed))  # NaN where it is unknown
        untouched = np.array([touch.free for touch in block.touches])
        free = untouched & block.v_ref.any(axis=1)
        signed = block.q - block.q_ref
        errors = np.abs(signed)
        error = errors.max(axis=1)
        recent = np.concatenate([self._recent, np.column_stack([use[:, -1], ~untouched])])
        if free.any():
            step = int(np.where(free, error, -1.0).argmax())
            if self.peak is None or error[step] > self.peak.error:
                before = recent[step + 1 : step + 1 + len(self._recent)]
                touched = np.flatnonzero(before[:, 1])
                after = (len(before) - 1 - int(touched[-1])) * self._dt if len(touched) else None
                joint, time = int(errors[step].argmax()), float(block.t[step])
                self.peak = Peak(float(error[step]), joint, time, float(before[:, 0].max()), after)
        self._recent = recent[len(block.touches) :]
        self.deflection = max(self.deflection, float(error[~free].max(initial=0.0)))
        return StepFigures(signed, free, use)

    @property
    def tracking_error(self) -> float | None:
        """Largest tracking error in free motion [rad]."""
        return self.peak and self.peak.error

    @property
    def limit_use(self) -> CycleLimitUse:
        """Largest fraction of each kind of limit."""
        return CycleLimitUse(*(float(use) for use in self._use))


class RobotState(NamedTuple):
    """State of a robot's gripper and controller between two ticks."""

    grip_forces: Sequence[float] = ()
    """Forces of the gripper's fingers [N]."""
    gripped: Sequence[str] = ()
    """Names of the objects that a closed gripper holds, with whatever force."""
    saturated_steps: int = 0
    """Control steps so far in which an effort was clipped."""


def live_state(cell: Any, commanded: Any) -> RobotState:
    """Return the present state of a `bt_manip.runner.CommandedRobot` in a `bt_manip.cell.Cell`."""
    gripper, saturated = commanded.gripper, commanded.controller.saturated_steps
    if gripper is None:
        return RobotState(saturated_steps=saturated)
    gripped = [n for n in gripper.held if cell.is_free(n)] if gripper.gripping else ()
    return RobotState(tuple(gripper.forces), gripped, saturated)


class RobotFigures(MotionStatistics):
    """Figures of a robot in each cycle.

    Args:
        joints: Names of its joints.
        limits: Their limits.
        dt: Time between two control steps [s].
        state: Returns its present state.
    """

    def __init__(
        self,
        joints: Sequence[str],
        limits: MotionLimits,
        dt: float,
        state: Callable[[], RobotState],
    ) -> None:
        self._joints, self._state = joints, state
        super().__init__(limits, dt)

    def begin(self) -> None:
        """Begin a cycle."""
        super().begin()
        self._grip: float | None = None
        self._picked: dict[str, None] = {}  # an ordered set
        self._saturated_before = self._state().saturated_steps

    def grasped(self) -> None:
        """Record the grip force at the end of a Grasp, if it holds something."""
        if self.gripped():
            self._grip = min(self._state().grip_forces, default=None)

    def gripped(self) -> Sequence[str]:
        """Record and return the objects that are gripped now; to be called after each tick."""
        names = self._state().gripped
        self._picked.update(dict.fromkeys(names))
        return names

    def cycle(self, start: float, leaf_at: Callable[[float], str]) -> RobotCycle:
        """Return the figures of the cycle.

        Args:
            start: Simulated time of its start [s].
            leaf_at: Returns the name of the action leaf that ran at a time of the cycle [s].
        """
        peak, tracking = self.peak, None
        if peak is not None:
            time = _seconds(peak.time - start)
            about = time, peak.effort, peak.after_contact
            tracking = TrackingPeak(self._joints[peak.joint], leaf_at(time), *about)
        return RobotCycle(
            picked=tuple(self._picked),
            grip_force_n=self._grip,
            max_tracking_error_rad=self.tracking_error,
            tracking_peak=tracking,
            max_deflection_rad=self.deflection,
            limits=self.limit_use,
            saturated_steps=self._state().saturated_steps - self._saturated_before,
            max_torque_rate_nm_s=self.torque_rate,
            max_tool_speed_m_s=self.tool_speed,
        )


def combined(robots: Iterable[RobotCycle]) -> RobotCycle:
    """Return the figures of a cycle over all robots: maxima, sums, or the least grip force."""
    cycles = list(robots)
    limits = np.array([astuple(cycle.limits) for cycle in cycles]).max(axis=0)
    grips = [c.grip_force_n for c in cycles if c.grip_force_n is not None]
    worst = max(cycles, key=lambda cycle: cycle.max_tracking_error_rad or 0.0)
    return RobotCycle(
        picked=tuple(dict.fromkeys(name for cycle in cycles for name in cycle.picked)),
        grip_force_n=min(grips, default=None),
        max_tracking_error_rad=worst.max_tracking_error_rad,
        tracking_peak=worst.tracking_peak,
        max_deflection_rad=max(cycle.max_deflection_rad for cycle in cycles),
        limits=CycleLimitUse(*limits.tolist()),
        saturated_steps=sum(cycle.saturated_steps for cycle in cycles),
        max_torque_rate_nm_s=max(cycle.max_torque_rate_nm_s for cycle in cycles),
        max_tool_speed_m_s=max(cycle.max_tool_speed_m_s for cycle in cycles),
    )


@dataclass(frozen=True)
class CycleFigures(RobotCycle):
    """Figures of a cycle: those of `RobotCycle` over all robots, and those of the tree.

    Attributes:
        number: Number of the cycle, from 1.
        status: ``"SUCCESS"``, ``"FAILURE"``, or ``"RUNNING"`` of one that has not ended.
        reason: Why it failed.
        start: Simulated time of its start [s].
        end: Simulated time of its end, or now [s].
        phases: The action leaves, in the order of their ends.
        robots: The figures of each robot, by name.
    """

    number: int = 1
    status: str = "RUNNING"
    reason: str = ""
    start: float = 0.0
    end: float = 0.0
    phases: tuple[Phase, ...] = ()
    robots: dict[str, RobotCycle] = field(default_factory=dict)

    @property
    def duration_s(self) -> float:
        """Simulated time that it took [s]."""
        return _seconds(self.end - self.start)


class RunFigures:
    """Figures of the present cycle of a run.

    Feed them in the order of time with the events of `kinds` (`handle`), before each start and end
    of a cycle with the control steps until then (`RobotFigures.update`), and call
    `RobotFigures.gripped` after each tick.

    Args:
        robots: Figures of each robot, by name.
        time: Simulated time [s].
        ended: Called with each execution of a node.

    Attributes:
        executions: Executions of the tree's nodes.
    """

    kinds = ("tree", "status", "cycle")

    def __init__(
        self,
        robots: Mapping[str, RobotFigures],
        time: float = 0.0,
        ended: Callable[[LoggedNode, Interval], None] = lambda node, interval: None,
    ) -> None:
        self.robots, self._also = robots, ended
        self.executions = ExecutionLog(self._ended)
        self._begin(1, time)

    def handle(self, event: RunEvent) -> None:
        """Take an event of the run."""
        if event.kind != "cycle":
            self.executions.handle(event)
        elif event.data["status"] == "RUNNING":
            self._begin(event.data["cycle"] + 1, event.time)
        else:
            self._status, self._reason = event.data["status"], event.data["reason"]

    def cycle(self, time: float) -> CycleFigures:
        """Return the figures of the present cycle until a simulated time [s]."""
        robots = {n: one.cycle(self._start, self._leaf_at) for n, one in self.robots.items()}
        return CycleFigures(
            number=self._number, status=self._status, reason=self._reason, start=self._start,
            end=time, phases=tuple(self._phases), robots=robots,
            **(vars(combined(robots.values())) if robots else {}),
        )  # fmt: skip

    @property
    def phases(self) -> Sequence[Phase]:
        """Action leaves that have ended in this cycle."""
        return self._phases

    def _begin(self, number: int, time: float) -> None:
        self._number, self._start = number, time
        self._status, self._reason = "RUNNING", ""
        self._phases: list[Phase] = []
        for robot in self.robots.values():
            robot.begin()

    def _ended(self, node: LoggedNode, interval: Interval, robot: str) -> None:
        self._also(node, interval)
        if node.kind != NodeKind.ACTION:
            return
        start, end, status, reason = interval
        status = status if status in ("SUCCESS", "FAILURE") else "HALTED"
        times = _seconds(start - self._start), _seconds(end - start)
        about = node.registration, node.name, status, "" if status == "SUCCESS" else reason
        self._phases.append(Phase(*about, *times))
        if node.registration == GRASP and self.robots:
            self.robots.get(robot, next(iter(self.robots.values()))).grasped()

    def _leaf_at(self, time: float) -> str:
        """Return the name of the leaf that ran at a time of the cycle [s], the last to start."""
        running = ((self.executions.nodes[uid], at) for uid, at in self.executions.running.items())
        started = [
            (_seconds(at - self._start), node.name)
            for node, at in running
            if node.kind == NodeKind.ACTION
        ]
        started += [(p.start_s, p.name) for p in self._phases if time <= p.start_s + p.duration_s]
        return max((one for one in started if one[0] < time), default=(0.0, ""))[1]


def _seconds(duration: float) -> float:
    """Round to microseconds: sums of control steps of 1 ms have rounding errors."""
    return round(duration, 6)
