"""Figures of a run, from its events, control steps and states of robots, live or recorded.

The report of a run feeds them while it goes on, the reader of its recording from the file.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

from bt_manip.bt.nodes import NodeKind
from bt_manip.record.motion_figures import MotionStatistics, combined
from bt_manip.record.report.run_report import Phase, RobotCycle, TrackingPeak
from bt_manip.robots import JointLimits
from bt_manip.runner import RunEvent, RunObserver

GRASP = "Grasp"
"""Registered name of the behaviour after which the grip force is measured."""


class Interval(NamedTuple):
    """Time in which a node ran or two bodies touched; both ends are equal where it took no time."""

    start: float
    """Simulated time [s]."""
    end: float
    """Simulated time [s]."""
    status: str
    """What the node ended with, ``"HALTED"``, or ``"RUNNING"`` if the recording ends before."""
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


class RobotState(Protocol):
    """State of a robot's gripper and controller between two ticks."""

    @property
    def grip_forces(self) -> Sequence[float]:
        """Forces of the gripper's fingers [N]."""

    @property
    def gripped(self) -> Sequence[str]:
        """Names of the objects that a closed gripper holds, with whatever force."""

    @property
    def saturated_steps(self) -> int:
        """Control steps since the start of the run in which an effort was clipped."""


class LiveState:
    """The `RobotState` of a robot now, read from the physics when it is asked.

    Args:
        cell: The `bt_manip.cell.Cell`.
        commanded: The `bt_manip.runner.CommandedRobot` in it.
    """

    def __init__(self, cell: Any, commanded: Any) -> None:
        self._cell, self._commanded = cell, commanded
        self._saturated_before = commanded.controller.saturated_steps

    @property
    def grip_forces(self) -> Sequence[float]:
        """Forces of the gripper's fingers [N]."""
        gripper = self._commanded.gripper
        return () if gripper is None else gripper.forces

    @property
    def gripped(self) -> Sequence[str]:
        """Names of the objects that a closed gripper holds, with whatever force."""
        gripper = self._commanded.gripper
        if gripper is None or not gripper.gripping:
            return ()
        return [name for name in gripper.held if self._cell.is_free(name)]

    @property
    def saturated_steps(self) -> int:
        """Control steps since the start of the run in which an effort was clipped."""
        return self._commanded.controller.saturated_steps - self._saturated_before


class RobotFigures:
    """Figures of a robot in each cycle.

    Args:
        joints: Names of its joints.
        limits: Their limits.
        dt: Time between two control steps [s].
        state: Its state now.

    Attributes:
        statistics: Maxima over its control steps.
        state: Its state now.
    """

    def __init__(
        self, joints: Sequence[str], limits: JointLimits, dt: float, state: RobotState
    ) -> None:
        self.statistics = MotionStatistics(limits, dt)
        self.state = state
        self._joints = joints
        self.begin()

    def begin(self) -> None:
        """Begin a cycle."""
        self.statistics.begin()
        self._grip: float | None = None
        self._picked: dict[str, None] = {}  # an ordered set
        self._saturated_before = self.state.saturated_steps

    def grasped(self) -> None:
        """Record the grip force at the end of a Grasp, if it holds something."""
        if self.gripped():
            self._grip = min(self.state.grip_forces, default=None)

    def gripped(self) -> Sequence[str]:
        """Record and return the objects that are gripped now; to be called after each tick."""
        names = self.state.gripped
        self._picked.update(dict.fromkeys(names))
        return names

    def cycle(self, start: float, leaf_at: Callable[[float], str]) -> RobotCycle:
        """Return the figures of the cycle.

        Args:
            start: Simulated time of its start [s].
            leaf_at: Returns the name of the action leaf that ran at a time of the cycle [s].
        """
        statistics, peak, tracking = self.statistics, self.statistics.peak, None
        if peak is not None:
            time = _seconds(peak.time - start)
            about = time, peak.effort, peak.after_contact
            tracking = TrackingPeak(self._joints[peak.joint], leaf_at(time), *about)
        return RobotCycle(
            picked=tuple(self._picked),
            grip_force_n=self._grip,
            max_tracking_error_rad=statistics.tracking_error,
            tracking_peak=tracking,
            max_deflection_rad=statistics.deflection,
            limits=statistics.limit_use,
            saturated_steps=self.state.saturated_steps - self._saturated_before,
            max_torque_rate_nm_s=statistics.torque_rate,
            max_tool_speed_m_s=statistics.tool_speed,
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

    They are fed with what happened, in this order: the events of `kinds` (`handle`), with the
    control steps before the start and the end of a cycle (`RobotFigures.statistics`) and the
    robots' states after each tick (`RobotFigures.gripped`).

    Args:
        robots: Figures of each robot, by name.
        time: Simulated time [s].
        ended: Called with each execution of a node.

    Attributes:
        robots: Figures of each robot, by name.
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
