"""Drop the held object into a container."""

import numpy as np

from bt_manip.bt import Input, Status

from .poses import bottom_pose, downward_poses
from .releasing import ReleasingBehaviour


class Drop(ReleasingBehaviour):
    """Move over a container, open the gripper, and wait until it is free."""

    container = Input(str, doc="Name of the container.")
    height = Input(float, default=0.25, doc="Height of the tool over the container's bottom [m].")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")

    def start(self) -> None:
        """Move to the nearest configuration over the container."""
        above = bottom_pose(self.cell, self.container).translation + np.array(
            [0.0, 0.0, self.height]
        )
        self.arm.move_to_pose(downward_poses(above), speed=self.speed)

    def arrived(self) -> Status:
        """Open the gripper and wait until it is free."""
        return self.release()
