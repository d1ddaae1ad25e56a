"""Drop the held object into a container."""

import numpy as np
import pinocchio as pin

from bt_manip.bt import Status
from bt_manip.cell import why_not_in
from bt_manip.exceptions import MotionError
from bt_manip.grasping import DROP_HEIGHTS

from .arm_behaviour import speed_input
from .automatic import first_reachable, number_or_auto
from .object_port import ObjectInput
from .poses import bottom_pose, downward_poses
from .releasing import ReleasingBehaviour

_TILT = 0.5  # [rad] largest tilt of the tool if obstacles block all vertical poses
_TILTS = [pin.SE3(pin.utils.rotate(axis, a), np.zeros(3)) for axis in "xy" for a in (-_TILT, _TILT)]


class Drop(ReleasingBehaviour):
    """Move over a container, open the gripper, and wait until the object is at rest inside.

    It fails if the gripper holds nothing, or if the object is lost during the motion or does not
    come to rest inside the container.
    """

    container = ObjectInput(str, doc="Name of the container.")
    height = number_or_auto(
        "Height of the tool over the container's bottom [m]; auto: 0.25, or the largest lower "
        "height in steps of 0.03 that the arm reaches, at least 0.1.",
        at_least=0.0,
    )
    speed = speed_input()

    def start(self) -> None:
        """Move to the nearest configuration over the container, tilted if obstacles require it."""
        self._carried = self.held_objects()
        if not self._carried:
            self.fail("the gripper holds nothing")
            return
        bottom = bottom_pose(self.cell, self.container).translation
        heights = DROP_HEIGHTS if self.height is None else (self.height,)
        first_reachable(heights, lambda height: self._move_over(bottom, height))

    def _move_over(self, bottom: np.ndarray, height: float) -> None:
        """Move the tool over the container's bottom.

        Raises:
            MotionError: If it is unreachable, or obstacles block all poses.
        """
        poses = downward_poses(bottom + np.array([0.0, 0.0, height]))
        try:
            self.arm.move_to_pose(poses, speed=self.speed)
        except MotionError as error:
            if error.reason != "collision":
                raise
            self.arm.move_to_pose([T * R for T in poses for R in _TILTS], speed=self.speed)

    def arrived(self) -> Status:
        """Open the gripper and wait until the object is at rest inside the container."""
        return self.release()

    def why_not_released(self, name: str) -> str:
        """Return why the object is not inside the container."""
        return why_not_in(self.cell, name, self.container)
