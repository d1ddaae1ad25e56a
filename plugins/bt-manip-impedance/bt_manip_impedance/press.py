"""Press a button."""

import numpy as np
import pinocchio as pin

from bt_manip.behaviours.arm_behaviour import MotionBehaviour
from bt_manip.bt import Input, Status
from bt_manip.cell import CellError

PRESSED = 0.95
"""Fraction of the travel at which a cap is down: the spring is stiff towards the end."""


class Press(MotionBehaviour):
    """Press a button all the way down and hold it, without ever pressing too hard.

    The tool is sent to a place inside the button, as if nobody knew exactly where that stands: how
    hard it presses is up to the controller's stiffness. A controller that insists on the place
    presses ever harder, until this fails.
    """

    memory = (*MotionBehaviour.memory, "_since")

    object = Input(str, doc="Name of the button.")
    depth = Input(float, default=0.02, doc="How far below the cap's top the tool is sent [m].")
    hold = Input(float, default=0.3, doc="How long it is held down [s].")
    max_force = Input(float, default=40.0, doc="Greatest force that the button may feel [N].")
    speed = Input(float, default=0.1, doc="Fraction of the arm's limits, above 0 and up to 1.")

    _since: float | None = None  # [s] when the cap was down

    def start(self) -> None:
        """Move straight down."""
        self._since = None
        button = self.cell.find(self.object)
        if not hasattr(button, "travel"):
            raise CellError(f"'{self.object}' is no button")
        T_wt, T_wo = self.T_wt, self.cell.pose(self.object)
        goal = T_wo.translation + np.array([0.0, 0.0, button.height - self.depth])
        # Motions keep off everything in the arm's world; this one is there to touch.
        world, self.arm.world = self.arm.world, None
        try:
            self.arm.move_linear(pin.SE3(T_wt.rotation, goal), speed=self.speed)
        finally:
            self.arm.world = world

    def update(self) -> Status:
        """Wait until the cap has been down for long enough."""
        button = self.cell.find(self.object)
        force = float(np.linalg.norm(self.cell.contacts.wrench(self.object).force))
        if force > self.max_force:
            return self.fail(
                f"'{self.object}' is pressed with {force:.1f} N, at most {self.max_force:g} N "
                "are allowed; a stiff controller cannot do this"
            )
        if button.depth < PRESSED * button.travel:
            self._since = None
        elif self._since is None:
            self._since = self.cell.time
        self.feedback_message = f"{1e3 * button.depth:.1f} mm down, {force:.1f} N"
        if self._since is not None and self.cell.time - self._since >= self.hold:
            return Status.SUCCESS
        if self.arm.moving or self._since is not None:
            return Status.RUNNING
        if self._ended is None:
            self._ended = self.cell.time
        if self.cell.time - self._ended > self.SETTLING:
            return self.fail(
                f"'{self.object}' is down by {1e3 * button.depth:.1f} of "
                f"{1e3 * button.travel:.1f} mm when the arm stands; it takes more depth, or more "
                "stiffness"
            )
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop pressing harder however it ends."""
        if new_status != Status.RUNNING and self.arm.moving:
            self.arm.stop()
