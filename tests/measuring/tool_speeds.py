"""Speeds of an arm's tool by MuJoCo, which shares no code with the limit of the tool's speed."""

from collections.abc import Iterable

import mujoco
import numpy as np

from bt_manip import load_plugins
from bt_manip.robots import Robot, RobotDescription, compile_alone, panda
from bt_manip.runner import Run, RunObserver, prepare, request_of

from .random_commands import STEP

KINDS = (
    "segment", "line", "turn", "blend", "servo", "follow", "stop", "pause", "scale", "back",
)  # fmt: skip
"""Kinds of random motions: those of `RandomCommands`."""


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


class ToolSpeeds(RunObserver):
    """Measures the speed of the only arm's tool in a run.

    Attributes:
        reference: Its largest speed by the reference [m/s].
        simulated: The same in the simulation, without the steps of a compliant arm.
        status: How the last cycle ended.
    """

    def __init__(self, description: RobotDescription) -> None:
        self._tool = ToolPositions(description)
        self._rows: list[np.ndarray] = []
        self._sites: list[np.ndarray] = []
        self.simulated, self.status = 0.0, ""

    def run_started(self, run: Run) -> None:
        """Begin."""
        self._arm = run.station.arm

    def after_step(self) -> None:
        """Take the reference and the position of the tool."""
        arm = self._arm
        self._rows.append(arm.q_ref)
        self._sites.append(arm.robot.tool_pose.translation)
        if len(self._sites) > 1 and not arm.compliant:
            moved = float(np.linalg.norm(self._sites[-1] - self._sites[-2]))
            self.simulated = max(self.simulated, moved / STEP)

    def cycle_started(self, cycle: int) -> None:
        """Begin again: the arm is put at home."""
        self._rows, self._sites = [], []

    def cycle_ended(self, status: str, reason: str) -> None:
        """Take the status."""
        self.status = status

    @property
    def reference(self) -> float:
        """Its largest speed by the reference [m/s]."""
        return self._tool.speed(self._rows)


def pick_and_place(seed: int, limit: float, blend_radius: float = 0.0) -> ToolSpeeds:
    """Run pick_place with a limit of the tool's speed [m/s] and a blend radius [m]."""
    parts, speeds = load_plugins().parts, ToolSpeeds(panda())
    settings = {"blend_radius": str(blend_radius)} if blend_radius else {}
    request = request_of("pick_place", parts, seed=seed, tool_speed=limit, settings=settings)
    prepare(request, parts).execute([speeds])
    return speeds
