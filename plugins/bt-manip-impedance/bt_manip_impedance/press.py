"""Press a button."""

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import MotionBehaviour
from bt_manip.bt import Input, Status
from bt_manip.cell import CellError

PRESSED = 0.95
"""Fraction of the travel at which a cap is down: the spring is stiff towards the end."""


CLEAR = 0.03
"""How far over the cap's top the tool goes afterwards [m]."""


class Press(MotionBehaviour):
    """Press a button all the way down, hold it, and let go, without ever pressing too hard.

    The tool is sent to a place inside the button, as if nobody knew exactly where that stands: how
    hard it presses is up to the controller's stiffness. A controller that insists on the place
    presses ever harder, until this lets go and fails.
    """

    memory = (*MotionBehaviour.memory, "_since", "_verdict")

    object = Input(str, doc="Name of the button.")
    depth = Input(float, default=0.02, doc="How far below the cap's top the tool is sent [m].")
    hold = Input(float, default=0.3, doc="How long it is held down [s].")
    max_force = Input(float, default=40.0, doc="Greatest force that the button may feel [N].")
    speed = Input(float, default=0.1, doc="Fraction of the arm's limits, above 0 and up to 1.")

    _since: float | None = None  # [s] when the cap was down
    _verdict: str | None = None  # why it will fail, empty for success; None while it presses

    def start(self) -> None:
        """Move straight down."""
        self._since = self._verdict = None
        button = self.cell.find(self.object)
        if not hasattr(button, "travel"):
            raise CellError(f"'{self.object}' is no button")
        self._move_over_the_cap(-self.depth)

    def update(self) -> Status:
        """Wait until the cap has been down for long enough, and then until it is free again."""
        if self._verdict is None:
            self._judge()
        elif not self.arm.moving:
            return self.fail(self._verdict) if self._verdict else Status.SUCCESS
        return Status.RUNNING

    def _judge(self) -> None:
        """Look at the button, and let go of it when there is a verdict."""
        button, now = self.cell.find(self.object), self.cell.time
        force = float(np.linalg.norm(self.cell.contacts.wrench(self.object).force))
        self.feedback_message = f"{1e3 * button.depth:.1f} mm down, {force:.1f} N"
        if button.depth < PRESSED * button.travel:
            self._since = None
        elif self._since is None:
            self._since = now
        if self._ended is None and not self.arm.moving:
            self._ended = now
        if force > self.max_force:
            self._verdict = (
                f"'{self.object}' is pressed with {force:.1f} N, at most {self.max_force:g} N "
                "are allowed; a stiff controller cannot do this"
            )
        elif self._since is not None:
            if now - self._since >= self.hold:
                self._verdict = ""
        elif self._ended is not None and now - self._ended > self.SETTLING:
            self._verdict = (
                f"'{self.object}' is down by {1e3 * button.depth:.1f} of "
                f"{1e3 * button.travel:.1f} mm when the arm stands; it takes more depth, or more "
                "stiffness"
            )
        if self._verdict is not None:
            self._move_over_the_cap(CLEAR)

    def _move_over_the_cap(self, height: float) -> None:
        """Move the tool straight to a height over the cap's top [m]."""
        T_wt, T_wo = self.T_wt, self.cell.pose(self.object)
        top = self.cell.find(self.object).height
        goal = T_wo.translation + np.array([0.0, 0.0, top + height])
        self.arm.move_linear(pin.SE3(T_wt.rotation, goal), speed=self.speed, contact=True)
