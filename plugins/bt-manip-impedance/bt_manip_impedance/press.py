"""Pressing a button."""

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import MotionBehaviour, feasible_force, number_or_auto
from bt_manip.bt import Input, Status
from bt_manip_impedance.approach import ApproachCondition, find_of
from bt_manip_impedance.push_button import PRESSED, PushButton

RELEASED = 1e-4  # [m] maximum depth of a released cap

MAX_FORCE = 40.0
"""Largest contact force, if the arm can exert it [N]."""

CLEAR = 0.03
"""Height of the tool over the cap after the retreat [m]."""


class Press(MotionBehaviour):
    """Press a button down, hold it and release it, with a limited force.

    The reference moves to a point inside the button, as if its position were not known exactly; the
    force depends on the controller's stiffness. With a stiff controller the force exceeds the
    limit, and the behaviour releases the button and fails.
    """

    memory = (*MotionBehaviour.memory, "_since", "_outcome", "_limit", "_last_force")

    object = Input(str, doc="Name of the button.")
    depth = Input(
        float, default=0.016, doc="Depth of the reference below the cap's top [m].", above=0.0
    )
    hold = Input(float, default=0.3, doc="Time for which it is held down [s].", at_least=0.0)
    max_force = number_or_auto(
        "Largest allowed contact force [N]; auto: 40, or 0.8 of the arm's maximum force if lower."
    )
    speed = Input(float, default=0.1, doc="Fraction of the arm's limits.", above=0.0, at_most=1.0)

    _last_force = 0.0  # [N] force at the last tick
    _limit = MAX_FORCE  # [N] largest allowed contact force
    _since: float | None = None  # [s] time at which the cap was down
    _outcome: str | None = None  # reason of a failure, empty for success; None while pressing

    def start(self) -> None:
        """Move straight down."""
        self._since, self._outcome, self._last_force = None, None, 0.0
        find_of(self.cell, self.object, PushButton)  # raises an error if it is something else
        given, down = self.max_force, np.array([0.0, 0.0, -1.0])
        self._limit = feasible_force(MAX_FORCE, self.arm, down) if given is None else given
        self._move_over_the_cap(-self.depth)

    def update(self) -> Status:
        """Hold the cap down for the given time, then wait for the retreat."""
        if self._outcome is None:
            self._check_button()
        elif not self.arm.moving:
            return self.fail(self._outcome) if self._outcome else Status.SUCCESS
        return Status.RUNNING

    def _check_button(self) -> None:
        """Measure depth and force; retreat once the outcome is known."""
        button, now = self.cell.find(self.object), self.cell.time
        pressing = float(np.linalg.norm(self.cell.contacts.wrench(self.object).force))
        force = min(pressing, self._last_force)  # ignores impacts
        self._last_force = pressing
        self.feedback_message = f"{1e3 * button.depth:.1f} mm down, {force:.1f} N"
        if button.depth < PRESSED * button.travel:
            self._since = None
        elif self._since is None:
            self._since = now
        if self._ended is None and not self.arm.moving:
            self._ended = now
        if force > self._limit:
            self._outcome = (
                f"'{self.object}' is pressed with {force:.1f} N, at most {self._limit:.3g} N "
                "are allowed; a stiff controller cannot do this"
            )
        elif self._since is not None:
            if now - self._since >= self.hold:
                self._outcome = ""
        elif self._ended is not None and now - self._ended > self.SETTLING:
            self._outcome = (
                f"'{self.object}' is down by {1e3 * button.depth:.1f} of "
                f"{1e3 * button.travel:.1f} mm when the arm has stopped; give it more depth or "
                "stiffness"
            )
        if self._outcome is not None:
            self._move_over_the_cap(CLEAR)

    def _move_over_the_cap(self, height: float) -> None:
        """Move the tool on a straight line to a height over the cap's top [m]."""
        T_wt, T_wo = self.T_wt, self.cell.pose(self.object)
        top = self.cell.find(self.object).height
        goal = T_wo.translation + np.array([0.0, 0.0, top + height])
        self.arm.move_linear(pin.SE3(T_wt.rotation, goal), speed=self.speed, contact=True)


class ButtonCondition(ApproachCondition):
    """A condition on a push button in the cell."""

    object = Input(str, doc="Name of the button.")

    @property
    def button(self) -> PushButton:
        """The button."""
        return find_of(self.cell, self.object, PushButton)


class IsReleased(ButtonCondition):
    """Check that a button is released."""

    def why_not(self) -> str:
        """Measure the depth of the cap."""
        depth = self.button.depth
        return f"'{self.object}' is {1e3 * depth:.1f} mm down" if not depth <= RELEASED else ""


class WasPressed(ButtonCondition):
    """Check that a button has been pressed since its creation; in a goal, in this cycle.

    A robot or an object may have pressed it. A press counts at its start: a button that has been
    down since an earlier cycle was not pressed in this one.
    """

    memory = ("_since",)

    released = Input(bool, default=False, doc="Whether it also must be released.")

    _since = 0.0  # [s] simulated time after which presses count

    def begin_cycle(self) -> None:
        """Count presses from now on."""
        self._since = self.cell.time

    @property
    def _was_pressed(self) -> bool:
        """Whether the button was pressed in the counted time."""
        pressed_at = self.button.pressed_at
        return pressed_at is not None and pressed_at > self._since

    def why_not(self) -> str:
        """Compare the time of the last press with the start of the cycle, and read the depth."""
        button = self.button
        if not self._was_pressed:
            return f"'{self.object}' was not pressed"
        if self.released and not button.depth <= RELEASED:
            return f"'{self.object}' is {1e3 * button.depth:.1f} mm down"
        return ""

    def progress(self) -> float:
        """Return the progress of approaching, pressing and releasing."""
        button = self.button
        down = min(max(button.depth / button.travel, 0.0), 1.0)
        if self._was_pressed:
            return 0.8 + 0.2 * (1.0 - down)
        top = self.cell.pose(self.object) * pin.SE3(np.eye(3), np.array([0, 0, button.height]))
        return 0.4 * self.closeness(top.translation) + 0.4 * down
