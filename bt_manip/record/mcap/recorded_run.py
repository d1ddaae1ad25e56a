"""A run as its recording tells it: cycles, nodes, contacts and motion over time."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.record.mcap.recording import Recording
from bt_manip.record.report.robot_log import limit_use
from bt_manip.record.report.run_report import CycleLimitUse

Leaves = tuple[dict[str, Any], ...]
"""Nodes, as the event ``tree`` describes them."""


class Interval(NamedTuple):
    """Time in which a node ran or two bodies touched; both ends are equal where it took no time."""

    start: float
    """Simulated time [s]."""
    end: float
    """Simulated time [s]."""
    status: str
    """What the node ended with, ``"HALTED"``, or ``"RUNNING"`` if the recording ends before."""
    reason: str = ""
    """Reason of a failure."""


class RecordedNode(NamedTuple):
    """A node of the tree; `intervals` are in the order of their ends."""

    name: str
    path: str
    depth: int
    is_leaf: bool
    intervals: list[Interval]


class RobotSeries(NamedTuple):
    """Motion and gripper of a robot over time."""

    joints: list[str]
    t: np.ndarray
    """Times of the control steps [s].  # (n,)"""
    error: np.ndarray
    """Tracking error: position minus reference [rad].  # (n, nq)"""
    free: np.ndarray
    """Whether it moved, grippers and the entities they hold touching only each other.  # (n,)"""
    use: np.ndarray
    """Largest fraction of each kind of limit, as in `CycleLimitUse`.  # (n, 5)"""
    tick_t: np.ndarray
    """Times of the ticks [s].  # (m,)"""
    grip_forces: np.ndarray
    """Forces of the gripper's fingers [N].  # (m, fingers)"""
    speed_scale: np.ndarray
    """Speed scaling of the arm.  # (m,)"""


class RecordedCycle(NamedTuple):
    """A cycle of a recorded run; the figures are those of `CycleReport`."""

    number: int
    status: str
    """``"RUNNING"`` if the recording ends before the cycle."""
    reason: str
    start: float
    """Simulated time [s]."""
    end: float
    """Simulated time [s]."""
    max_tracking_error_rad: float | None = None
    limits: CycleLimitUse = CycleLimitUse()


class RecordedRun:
    """Description of a run in its recording.

    Attributes:
        recording: The recording.
        nodes: The nodes in the order of the tree; those of an edited tree come last.
        contacts: Intervals in which two bodies touched, by their names.
        faults: Time, robot and reason of motions that were stopped.
        robots: Motion of the robots, by name.
        cycles: The cycles.
    """

    def __init__(self, recording: Recording) -> None:
        """Read the recording.

        Raises:
            BtManipError: If it is not that of a run.
        """
        if "/tree/nodes" not in recording.topics:
            how = "" if recording.complete else ", and ended without an end"
            raise BtManipError(
                f"{recording.path} is not the recording of a run: it has no tree{how}"
            )
        self.recording = recording
        self.nodes: dict[str, RecordedNode] = {}  # by path, which may have a number
        self.contacts: dict[tuple[str, str], list[Interval]] = {}
        self.faults: list[tuple[float, str, str]] = []
        self.cycles: list[RecordedCycle] = []
        running: dict[str, float] = {}  # starts of nodes, by key of `nodes`
        touching: dict[tuple[str, str], float] = {}
        with recording.decoding():
            for time, kind, data in recording.events():
                if kind == "tree":
                    self._end(running, time, "HALTED")
                    self._add_nodes(data["nodes"])
                elif kind == "status":
                    self._change(running, time, data)
                elif kind == "contact":
                    pair = (data["first"], data["second"])
                    if data["touching"]:
                        touching[pair] = time
                    elif pair in touching:
                        interval = Interval(touching.pop(pair), time, "")
                        self.contacts.setdefault(pair, []).append(interval)
                elif kind == "motion" and data["fault"]:
                    self.faults.append((time, data["robot"], data["fault"]))
                elif kind == "cycle" and data["status"] == "RUNNING":
                    number, end = data["cycle"] + 1, recording.end
                    self.cycles.append(RecordedCycle(number, "RUNNING", "", time, end))
                elif kind == "cycle" and self.cycles:
                    status, reason = data["status"], data["reason"]
                    self.cycles[-1] = self.cycles[-1]._replace(
                        status=status, reason=reason, end=time
                    )
        self._end(running, recording.end, "RUNNING")
        for pair, start in touching.items():
            self.contacts.setdefault(pair, []).append(Interval(start, recording.end, ""))
        with recording.decoding():
            self.robots = {name: self._series(name) for name in recording.limits}
            self.cycles = [self._with_figures(cycle) for cycle in self.cycles]

    # Internal

    def _add_nodes(self, nodes: list[dict[str, Any]]) -> None:
        depths, parents = {0: -1}, {node["parent"] for node in nodes}
        self._keys: dict[int, str] = {}  # of `nodes`, by uid
        for node in nodes:
            uid, key = node["uid"], node["path"]
            if key in self._keys.values():  # two nodes of one name
                key = f"{key}::{uid}"
            depth = depths[uid] = depths.get(node["parent"], -1) + 1
            intervals = self.nodes[key].intervals if key in self.nodes else []
            leaf = uid not in parents
            self.nodes[key] = RecordedNode(node["name"], node["path"], depth, leaf, intervals)
            self._keys[uid] = key

    def _change(self, running: dict[str, float], time: float, data: dict[str, Any]) -> None:
        key, status = self._keys[data["uid"]], data["status"]
        start = running.pop(key, None)
        if status == "RUNNING":
            running[key] = time if start is None else start
        elif start is not None or status in ("SUCCESS", "FAILURE"):
            ended = "HALTED" if status == "IDLE" else status
            interval = Interval(time if start is None else start, time, ended, data["reason"])
            self.nodes[key].intervals.append(interval)

    def _end(self, running: dict[str, float], time: float, status: str) -> None:
        """End the intervals of the nodes that run."""
        for key, start in running.items():
            self.nodes[key].intervals.append(Interval(start, time, status))
        running.clear()

    def _series(self, robot: str) -> RobotSeries:
        recording = self.recording
        steps = recording.control_steps(robot)
        a_ref = steps["a_ref"]
        jerk = np.diff(a_ref, axis=0, prepend=a_ref[:1]) / recording.identity["time_step_s"]
        limits = recording.limits[robot]
        use = limit_use(limits, steps["q_ref"], steps["v_ref"], a_ref, jerk, steps["tau"])
        ticks, forces, scales = [], [], []
        for time, _, state in recording.messages(f"/robots/{robot}/state"):
            ticks.append(time)
            forces.append(state["grip_forces"])
            scales.append(state["speed_scale"])
        return RobotSeries(
            recording.joints[robot],
            steps["t"],
            steps["q"] - steps["q_ref"],
            steps["free"] & steps["v_ref"].any(axis=1),
            use,
            np.array(ticks),
            np.array(forces) if forces else np.zeros((0, 0)),
            np.array(scales),
        )

    def _with_figures(self, cycle: RecordedCycle) -> RecordedCycle:
        """Return a cycle with its largest tracking error and use of limits."""
        errors, uses = [np.zeros(0)], [np.zeros((1, 5))]
        for robot in self.robots.values():
            steps = slice(*np.searchsorted(robot.t, (cycle.start, cycle.end), side="right"))
            errors.append(np.abs(robot.error[steps][robot.free[steps]]).ravel())
            uses.append(robot.use[steps])
        error = np.concatenate(errors)
        return cycle._replace(
            max_tracking_error_rad=float(error.max()) if len(error) else None,
            limits=CycleLimitUse(*np.concatenate(uses).max(axis=0).tolist()),
        )


def running_leaves(recording: Recording, t: Sequence[float] | np.ndarray) -> list[Leaves]:
    """Return the running leaves of the tree in the ticks of the control steps at some times.

    Args:
        recording: The recording.
        t: Ends of the control steps [s].  # (n,)
    """
    nodes: dict[int, dict[str, Any]] = {}
    running: dict[int, dict[str, Any]] = {}
    changes: list[float] = []  # [s]
    leaves: list[Leaves] = [()]  # before and after each change
    for event in recording.events("tree", "status"):
        if event.kind == "tree":
            parents = {node["parent"] for node in event.data["nodes"]}
            nodes = {n["uid"]: n for n in event.data["nodes"] if n["uid"] not in parents}
            running = {}
        elif event.data["uid"] in nodes:
            uid = event.data["uid"]
            running.pop(uid, None)
            if event.data["status"] == "RUNNING":
                running[uid] = nodes[uid]
        else:
            continue
        changes.append(event.time)
        leaves.append(tuple(running.values()))
    return [leaves[i] for i in np.searchsorted(changes, t, side="left").tolist()]
