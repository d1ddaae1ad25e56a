"""Records of one robot in a run."""

from collections.abc import Iterable
from dataclasses import astuple
from typing import Any

import numpy as np

from bt_manip.recording.motion_statistics import MotionStatistics
from bt_manip.recording.report import CycleLimitUse, RobotCycle
from bt_manip.recording.step_log import StepBlock, StepLog


class RobotLog:
    """Copies a robot's control steps and computes its figures for each cycle.

    Attributes:
        name: The robot's name.
        grip: Least of the gripper's forces at the end of the last Grasp [N], or None.
        picked: Names of the objects gripped in this cycle.
    """

    def __init__(self, cell: Any, robot: Any) -> None:
        """Bind to a robot.

        Args:
            cell: The `bt_manip.cell.Cell`.
            robot: The `bt_manip.runner.CommandedRobot`.
        """
        self.name = robot.name
        self._robot = robot
        self.steps = StepLog(cell, robot)
        self.statistics = MotionStatistics(robot.robot.limits, cell.dt)
        self.begin()

    def begin(self) -> None:
        """Start a cycle."""
        self.statistics.begin()
        self.grip: float | None = None
        self.picked: list[str] = []
        self._saturated_before = self._robot.controller.saturated_steps

    def take(self) -> StepBlock:
        """Evaluate and return the steps since the last call."""
        block = self.steps.take()
        self.statistics.update(
            q=block.q, q_ref=block.q_ref, v_ref=block.v_ref, a_ref=block.a_ref, tau=block.tau,
            tool=block.tool,
            free=np.fromiter((touch.free for touch in block.touches), bool, len(block.touches)),
        )  # fmt: skip
        return block

    def grasped(self) -> None:
        """Record the held objects and the grip force."""
        gripper = self._robot.gripper
        self.grip = min(gripper.forces, default=None)
        self.picked += [name for name in gripper.held if name not in self.picked]

    def cycle(self) -> RobotCycle:
        """Return the figures of the cycle."""
        statistics = self.statistics
        return RobotCycle(
            picked=tuple(self.picked),
            grip_force_n=self.grip,
            max_tracking_error_rad=statistics.tracking_error,
            limits=statistics.limit_use,
            saturated_steps=self._robot.controller.saturated_steps - self._saturated_before,
            max_torque_rate_nm_s=statistics.torque_rate,
            max_tool_speed_m_s=statistics.tool_speed,
        )


def combined(robots: Iterable[RobotCycle]) -> dict[str, Any]:
    """Return the figures of a cycle over all robots, by the fields of `CycleReport`."""
    cycles = list(robots)
    limits = np.array([astuple(cycle.limits) for cycle in cycles]).max(axis=0)
    grips = [c.grip_force_n for c in cycles if c.grip_force_n is not None]
    errors = [c.max_tracking_error_rad for c in cycles if c.max_tracking_error_rad is not None]
    return {
        "grip_force_n": min(grips, default=None),
        "max_tracking_error_rad": max(errors, default=None),
        "limits": CycleLimitUse(*limits.tolist()),
        "saturated_steps": sum(cycle.saturated_steps for cycle in cycles),
        "max_torque_rate_nm_s": max(cycle.max_torque_rate_nm_s for cycle in cycles),
        "max_tool_speed_m_s": max(cycle.max_tool_speed_m_s for cycle in cycles),
    }
