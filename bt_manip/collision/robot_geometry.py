"""The bodies of a robot and its held object at any configuration."""

from typing import TYPE_CHECKING, NamedTuple

import mujoco
import numpy as np

from bt_manip import spatial
from bt_manip.cell import BodyNames, entity_of
from bt_manip.robots import Robot, RobotModel

if TYPE_CHECKING:
    from bt_manip.arm import Arm


class RobotGeometry:
    """Places the bodies of a robot and its held object at a configuration.

    Only this class knows the gripper's contact bodies, held object and opening in collision checks.
    An empty gripper may open at any time, so it counts as open for other robots.

    Args:
        model: The robot's kinematic model, which is copied.

    Attributes:
        robot: The robot.
        arm: Mask of the bodies that the arm moves.  # (nbody,)
        held_root: Root body of the held object; 0 without one.
        gripping: Mask of the gripper's contact bodies and the held object; these may touch each
            other.  # (nbody,)
        bodies: Mask of the bodies of the arm and the held object; each change creates a new
            array.  # (nbody,)
    """

    def __init__(self, robot: Robot, model: RobotModel) -> None:
        self.robot = robot
        self._kinematics = model.copy()
        self._source: mujoco.MjModel | None = None
        self.held_root: int
        self.refresh()

    def refresh(self, *, empty: bool = False) -> None:
        """Update the held object and its pose in the tool frame.

        Args:
            empty: Whether the gripper counts as empty.
        """
        robot = self.robot
        model, data = robot.mj_model, robot.mj_data
        gripper = robot.gripper
        held = gripper.held_root() if gripper is not None and not empty else 0
        if model is not self._source or held != self.held_root:
            self._source, self.held_root = model, held
            self._adr = np.array(robot.qpos_adr)
            self.arm = moved_bodies(model, robot.dof_adr)
            self.gripping = (model.body_rootid == held) & (held > 0)
            self.bodies = self.arm | self.gripping
            if gripper is not None:
                self.gripping[list(gripper.contact_body_ids)] = True
        if held:
            start = int(model.jnt_qposadr[model.body_jntadr[held]])
            self._held_position = slice(start, start + 3)
            self._held_quaternion = slice(start + 3, start + 7)
            T_wo = spatial.pose(data.qpos[self._held_position], data.qpos[self._held_quaternion])
            self._T_to = self._kinematics.pose(data.qpos[self._adr]).actInv(T_wo)

    @property
    def held(self) -> str:
        """Name of the held object; empty without one."""
        if not self.held_root:
            return ""
        return entity_of(BodyNames(self.robot.mj_model).of_body[self.held_root])

    def write(self, qpos: np.ndarray, q: np.ndarray) -> None:
        """Write the positions of the arm and the held object into a ``qpos``.

        Args:
            qpos: Positions of all joints of the compiled model.
            q: Configuration of the arm [rad].  # (nq,)
        """
        qpos[self._adr] = q
        if self.held_root:
            T_wo = self._kinematics.pose(q) * self._T_to
            qpos[self._held_position] = T_wo.translation
            mujoco.mju_mat2Quat(qpos[self._held_quaternion], T_wo.rotation.ravel())

    def write_open_gripper(self, qpos: np.ndarray) -> None:
        """Write the positions of the open gripper into a ``qpos``, unless it holds an object."""
        if not self.held_root and self.robot.gripper is not None:
            self.robot.gripper.set_opening(qpos)


class OtherRobot(NamedTuple):
    """Another robot of the cell, as an obstacle.

    Attributes:
        name: Its name in the cell.
        geometry: Its bodies and held object.
        arm: Its arm, whose `target` is its final configuration.
    """

    name: str
    geometry: RobotGeometry
    arm: "Arm"


def moved_bodies(model: mujoco.MjModel, dofs: np.ndarray) -> np.ndarray:
    """Return the mask of the bodies moved by degrees of freedom, with their descendants."""
    moved = np.zeros(model.nbody, dtype=bool)
    moved[model.dof_bodyid[dofs]] = True
    for body in range(1, model.nbody):  # a parent always comes before its children
        moved[body] |= moved[model.body_parentid[body]]
    return moved  # (nbody,)
