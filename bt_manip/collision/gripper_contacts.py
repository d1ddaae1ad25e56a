"""All that collision checking is told about a robot's gripper."""

import mujoco
import numpy as np

from bt_manip.robots import Robot

_FREE = int(mujoco.mjtJoint.mjJNT_FREE)


class GripperContacts:
    """The interface between a gripper and collision checking.

    Collision checking needs three things: which bodies may touch the held object (`bodies`), which
    object is held (`held_root`), and how an empty gripper opens (`write_open`).
    """

    def __init__(self, robot: Robot) -> None:
        """Take the gripper of a compiled robot."""
        self._robot = robot

    @property
    def bodies(self) -> tuple[int, ...]:
        """Ids of the bodies that hold objects: they may touch these and each other."""
        return self._robot.finger_body_ids

    def held_root(self) -> int:
        """Return the root body of the free object that all `bodies` touch; 0 without one."""
        model, data = self._robot.mj_model, self._robot.mj_data
        if not self.bodies or not data.ncon:
            return 0
        pairs = model.geom_bodyid[data.contact.geom]  # (ncon, 2)
        touched = [
            {int(root) for root in model.body_rootid[pairs[:, ::-1][pairs == body]]}
            for body in self.bodies
        ]
        roots = sorted(set.intersection(*touched))
        return next((root for root in roots if _is_free(model, root)), 0)

    def write_open(self, qpos: np.ndarray) -> None:
        """Write the positions of the open gripper's joints into a ``qpos``."""
        if self._robot.description.gripper is not None:
            self._robot.set_opening(qpos, self._robot.gripper_travel.open_width)


def _is_free(model: mujoco.MjModel, body: int) -> bool:
    joint = int(model.body_jntadr[body])
    return joint >= 0 and int(model.jnt_type[joint]) == _FREE
