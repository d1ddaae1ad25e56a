"""Speeds of an arm's tool by MuJoCo, which shares no code with the limit of the tool's speed."""

from collections.abc import Iterable

import mujoco
import numpy as np

from bt_manip.robots import Robot, RobotDescription, compile_alone

STEP = 1e-3  # [s]


class ToolPositions:
    """Positions of a robot's tool, by MuJoCo's kinematics."""

    def __init__(self, robot: Robot | RobotDescription) -> None:
        if not isinstance(robot, Robot):
            robot = Robot(robot)
            compile_alone(robot)
        self._robot = robot

    def speed(self, q: Iterable[np.ndarray]) -> float:
        """Return the largest speed of the tool by configurations at control steps [m/s]."""
        return float(self.speeds(q).max(initial=0.0))

    def speeds(self, q: Iterable[np.ndarray]) -> np.ndarray:
        """Return the speeds of the tool by configurations at control steps [m/s].

        Args:
            q: Configurations [rad].  # (n, nq)
        """  # (n - 1,)
        robot = self._robot
        model, data = robot.mj_model, robot.mj_data
        positions = []
        for row in q:
            data.qpos[robot.qpos_adr] = row
            mujoco.mj_kinematics(model, data)
            positions.append(data.site_xpos[robot.tool_site_id].copy())
        return np.asarray(np.linalg.norm(np.diff(positions, axis=0), axis=1)) / STEP
