"""Cycles, nodes, contacts and motion of a recorded run over time."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.record import (
    CycleFigures,
    ExecutionLog,
    Interval,
    LoggedNode,
    RobotFigures,
    RobotState,
    RunFigures,
)
from bt_manip_recording.recording import Recording


class RecordedRobot:
    """Motion and gripper of a robot over time, with the figures of its cycles.

    Args:
        recording: The recording.
        robot: Name of the robot.

    Attributes:
        joints: Names of its joints.
        t: Times of the control steps [s].  # (n,)
        error: Tracking error: position minus reference [rad].  # (n, nq)
        use: Largest fraction of each kind of limit, as in `CycleLimitUse`.  # (n, 5)
        tick_t: Times of the ticks [s].  # (m,)
        grip_forces: Forces of the gripper's fingers [N].  # (m, fingers)
        speed_scale: Speed scaling of the arm.  # (m,)
        figures: Figures of the cycle so far.
    """

    def __init__(self, recording: Recording, robot: str) -> None:
        self.joints, self._block = recording.joints[robot], recording.step_block(robot)
        topic = f"/robots/{robot}/state"  # missing where only the states of a page were saved
        found = list(recording.messages(topic)) if topic in recording.topics else []
        self._states = [state for _, _, state in found]
        self.t, self.tick_t = self._block.t, np.array([time for time, _, _ in found])
        self.error, self.use = np.zeros_like(self._block.q), np.zeros((len(self.t), 5))
        forces = [state["grip_forces"] for state in self._states]
        self.grip_forces = np.array(forces) if forces else np.zeros((0, 0))
        self.speed_scale = np.array([state["speed_scale"] for state in self._states])
        dt, self._state = recording.identity["time_step_s"], RobotState()
        self.figures = RobotFigures(self.joints, recording.limits[robot], dt, lambda: self._state)
        self._ticks = self._steps = 0  # that have been fed

    def feed_ticks(self, time: float) -> None:
        """Feed the states after the ticks up to a simulated time [s]."""
        end = int(np.searchsorted(self.tick_t, time, side="right"))
        for state in self._states[self._ticks : end]:
            of_gripper = state["grip_forces"], state["gripped"]
            self._state = RobotState(*of_gripper, state["saturated_steps"])
            self.figures.gripped()
        self._ticks = end

    def feed_steps(self, time: float) -> None:
        """Feed the control steps up to a simulated time [s]."""
        start = self._steps
        self._steps = end = int(np.searchsorted(self.t, time, side="right"))
        if end > start:
            part = self.figures.update(self._block.part(start, end))
            self.error[start:end], self.use[start:end] = part.error, part.use


class RecordedRun:
    """Description of a run in its recording.

    Attributes:
        recording: The recording.
        nodes: The nodes in the order of the tree; those of an edited tree come last.
        contacts: Intervals in which two bodies touched, by their names.
        faults: Time, robot and reason of motions that were stopped.
        robots: Motion of the robots, by name.
        cycles: The cycles.

    Raises:
        BtManipError: If it is not that of a run.
    """

    def __init__(self, recording: Recording) -> None:
        if "/tree/nodes" not in recording.topics:
            how = "" if recording.complete else ", and ended without an end"
            raise BtManipError(
                f"{recording.path} is not the recording of a run: it has no tree{how}"
            )
        self.recording = recording
        self.nodes: dict[str, LoggedNode] = {}
        self.contacts: dict[tuple[str, str], list[Interval]] = {}
        self.faults: list[tuple[float, str, str]] = []
        self.cycles: list[CycleFigures] = []
        with recording.decoding():
            self.robots = {name: RecordedRobot(recording, name) for name in recording.limits}
            self._read()

    def _read(self) -> None:
        """Feed the figures with the events, and with the robots' steps and states between them."""

        def ended(node: LoggedNode, interval: Interval) -> None:
            self.nodes[node.key].intervals.append(interval)

        figures = RunFigures({n: one.figures for n, one in self.robots.items()}, ended=ended)
        touching: dict[tuple[str, str], float] = {}
        end, is_open = self.recording.end, False
        for event in self.recording.events():
            time, kind, data = event
            for robot in self.robots.values():
                robot.feed_ticks(time)
                if kind == "cycle":
                    robot.feed_steps(time)
            if kind in figures.kinds:
                figures.handle(event)
            if kind == "tree":
                for node in figures.executions.nodes.values():
                    known = self.nodes.get(node.key, node)
                    self.nodes[node.key] = replace(node, intervals=known.intervals)
            elif kind == "contact":
                pair = (data["first"], data["second"])
                if data["touching"]:
                    touching[pair] = time
                elif pair in touching:
                    self._touched(pair, touching.pop(pair), time)
            elif kind == "motion" and data["fault"]:
                self.faults.append((time, data["robot"], data["fault"]))
            elif kind == "cycle":
                is_open = data["status"] == "RUNNING"
                if not is_open:
                    self.cycles.append(figures.cycle(time))
        for robot in self.robots.values():
            robot.feed_ticks(end)
            robot.feed_steps(end)
        if is_open:
            self.cycles.append(figures.cycle(end))
        figures.executions.end(end, "RUNNING")
        for pair, start in touching.items():
            self._touched(pair, start, end)

    def _touched(self, pair: tuple[str, str], start: float, end: float) -> None:
        self.contacts.setdefault(pair, []).append(Interval(start, end, ""))


def running_leaves(
    recording: Recording, t: Sequence[float] | np.ndarray
) -> list[tuple[LoggedNode, ...]]:
    """Return the running leaves of the tree in the ticks of the control steps at some times.

    Args:
        recording: The recording.
        t: Ends of the control steps [s].  # (n,)
    """
    executions = ExecutionLog(lambda node, interval, robot: None)
    changes: list[float] = []  # [s]
    leaves: list[tuple[LoggedNode, ...]] = [()]  # before and after each change
    for event in recording.events(*executions.kinds):
        executions.handle(event)
        changes.append(event.time)
        leaves.append(executions.running_leaves)
    return [leaves[i] for i in np.searchsorted(changes, t, side="left").tolist()]
