"""Drop what the gripper holds into a container."""

import numpy as np

from bt_manip.bt import Input, Status

from .arm_behaviour import MotionBehaviour
from .poses import bottom_pose, turned


class Drop(MotionBehaviour):
    """Move over a container, open the fingers, and wait until nothing touches them."""

    container = Input(str, doc="Name of the container.")
    height = Input(float, default=0.25, doc="Height of the tool over the container's bottom [m].")
    speed = Input(float, default=1.0, doc="Fraction of the arm's limits, above 0 and up to 1.")
    patience = Input(float, default=2.0, doc="Longest simulated time for the fingers to open [s].")

    memory = (*MotionBehaviour.memory, "_opening")

    _opening: float | None = None  # [s] when the fingers began to open

    def start(self) -> None:
        """Move to the nearest of the configurations over the container."""
        self._opening = None
        above = bottom_pose(self.cell, self.container).translation + np.array(
            [0.0, 0.0, self.height]
        )
        self.arm.move_to_pose(turned(above), speed=self.speed)

    def arrived(self) -> Status:
        """Open, and wait until the fingers are free."""
        if self._opening is None:
            self._opening = self.cell.time
            self.gripper.open()
        self.feedback_message = f"opening, {1000 * self.gripper.width:.0f} mm"
        if self.gripper.is_free and self.gripper.is_open:
            self.arm.payload = None
            return Status.SUCCESS
        if self.cell.time - self._opening > self.patience:
            touching = ", ".join(self.gripper.held) or "nothing"
            return self.fail(f"the fingers still touch {touching} after {self.patience:g} s")
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Brake, and keep the fingers where they are, when halted."""
        super().terminate(new_status)
        if new_status == Status.INVALID:
            self.gripper.stop()
