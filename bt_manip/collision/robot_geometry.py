"""A robot with what it holds, to be put anywhere in a copy of the physics."""

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import BodyNames, entity_of
from bt_manip.robots import Robot, RobotModel

from .held import held_root
from .scratch_model import moved_bodies


class RobotGeometry:
    """Where the bodies of a robot, and of what its fingers hold, come to be with its arm.

    Fingers that hold nothing may open at any time, and count as open.

    Attributes:
        robot: The robot.
        arm: Marks the bodies that its arm moves.  # (nbody,)
        held_root: Root body of what it holds; 0 where that is nothing.
        bodies: Marks both; a new array where they are others than before.  # (nbody,)
    """

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        """Look at a robot.

        Args:
            robot: The robot, compiled into a world.
            model: Its model, for where the tool is.
        """
        self.robot = robot
        self._kinematics = model.copy()
        self._source: mujoco.MjModel | None = None
        self.held_root = 0
        self.refresh()

    def refresh(self) -> None:
        """Take over what is held, and how."""
        robot = self.robot
        model, data = robot.mj_model, robot.mj_data
        held = held_root(model, data, robot.finger_body_ids)
        if model is not self._source or held != self.held_root:
            self._source, self.held_root = model, held
            self._adr = np.array(robot.qpos_adr)
            self.arm = moved_bodies(model, robot.dof_adr)
            self.bodies = self.arm | ((model.body_rootid == held) & (held > 0))
        self._start = 0
        if held:
            self._start = int(model.jnt_qposadr[model.body_jntadr[held]])
            q = data.qpos[self._start : self._start + 7]
            T_wt = self._kinematics.pose(data.qpos[self._adr])
            self._T_to = T_wt.actInv(spatial.pose(q[:3], q[3:]))

    @property
    def held(self) -> str:
        """Name of what it holds; empty where that is nothing."""
        if not self.held_root:
            return ""
        return entity_of(BodyNames(self.robot.mj_model).of_body[self.held_root])

    def carried(self, q: np.ndarray) -> pin.SE3 | None:
        """Give where what is held comes to be, with the arm at a configuration; None for nothing.

        Args:
            q: Positions of the arm's joints [rad].  # (nq,)
        """
        return self._kinematics.pose(q) * self._T_to if self.held_root else None

    def put(self, qpos: np.ndarray, q: np.ndarray) -> None:
        """Write where it is, with its arm at a configuration, into positions of the physics.

        Args:
            qpos: All positions, which are changed.
            q: Positions of the arm's joints [rad].  # (nq,)
        """
        qpos[self._adr] = q
        T_wo, start = self.carried(q), self._start
        if T_wo is not None:
            qpos[start : start + 3] = T_wo.translation
            mujoco.mju_mat2Quat(qpos[start + 3 : start + 7], T_wo.rotation.ravel())

    def spread(self, qpos: np.ndarray) -> None:
        """Open the fingers in positions of the physics, where they hold nothing."""
        if not self.held_root and self.robot.description.gripper is not None:
            self.robot.set_opening(qpos, self.robot.gripper_travel.open_width)
