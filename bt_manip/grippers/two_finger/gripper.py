"""A two-finger gripper: position control while moving, force control while holding."""

from collections.abc import Callable

import numpy as np
from dm_control import composer
from dm_control.composer.observation import observable

from bt_manip.robots import GripperConnection, GripperError, Robot

from .fingers import (
    CLOSING,
    GRIPPING,
    MET,
    MOVING,
    PRESSING,
    RAMP,
    RELEASING,
    STILL,
    DrivenFingers,
)
from .hardware import RealTwoFingerGripper

_RELEASE = 0.04  # [s] fall time of the force before opening
_STEADY_TIME = 0.05  # [s] inside the force band until the grip is steady


class TwoFingerGripperObservables(composer.Observables):
    """Joint positions, opening and finger forces."""

    @composer.observable
    def positions(self) -> observable.Observable:
        """Positions of the two joints that move the fingers [m] or [rad]."""
        return observable.MJCFFeature("qpos", self._entity.mechanism.joints)

    @composer.observable
    def width(self) -> observable.Observable:
        """Distance between the fingers [m]."""
        return observable.Generic(lambda physics: np.array([self._entity.width]))

    @composer.observable
    def forces(self) -> observable.Observable:
        """Normal force on each finger in the last step [N]."""
        return observable.Generic(lambda physics: np.array(self._entity.forces))


class TwoFingerGripper(DrivenFingers):
    """A gripper that opens and closes two fingers, and holds with a force.

    Each finger moves with 0.1 m/s, or less if this is the gripper's maximum or if the finger could
    not stop within 1.5 mm.
    """

    @classmethod
    def on_device(cls, connection: GripperConnection) -> Callable[[Robot], RealTwoFingerGripper]:
        """Return a factory of this gripper with the fingers of a real gripper."""
        return lambda robot: RealTwoFingerGripper(robot, connection)

    def _build_observables(self) -> TwoFingerGripperObservables:
        return TwoFingerGripperObservables(self)

    # Commands

    def open(self) -> None:
        """Open fully, after reducing the force on a held object smoothly to zero."""
        self.move(self._open)

    def move(self, width: float) -> None:
        """Move to an opening [m].

        Raises:
            GripperError: If the gripper cannot reach this opening.
        """
        self._check_width(width)
        self._limits = self._stroke_limits()
        self._target = 0.5 * width
        if self.state in PRESSING:
            self._change_force(RELEASING, 0.0, _RELEASE)
        else:
            self._travel(self._target)
            self.state = MOVING

    def close(self, force: float = 50.0) -> None:
        """Close until both fingers press with a force [N] each, or touch each other.

        Raises:
            GripperError: If the gripper cannot reach this force.
        """
        force = self.check_force(force)
        self._limits = self._stroke_limits()
        self._asked = force
        self._in_band = 0
        if self.state in PRESSING:
            self._change_force(GRIPPING, force, RAMP)
        else:
            self._slowed = False
            self._travel(0.5 * self._min)
            self.state = CLOSING

    def stop(self) -> None:
        """Stop the fingers; a held object stays held."""
        if self.state in (MOVING, CLOSING):
            self._travel(None)
            self.state = MOVING
        elif self.state == RELEASING:
            self._change_force(GRIPPING, self._asked, RAMP)

    # Measurements

    @property
    def moving(self) -> bool:
        """Whether a command is still being executed."""
        return self.state in (MOVING, CLOSING, RELEASING) or (
            self.state == GRIPPING and not (self.steady or self.closed_on_nothing)
        )

    @property
    def gripping(self) -> bool:
        """Whether its last command was to close."""
        return self.state in (CLOSING, GRIPPING)

    @property
    def steady(self) -> bool:
        """Whether each finger has pressed with 95 to 120 % of the commanded force for 50 ms."""
        return (
            self.state == GRIPPING
            and self._in_band * self._dt >= _STEADY_TIME - 1e-9
            and not self.closed_on_nothing
        )

    @property
    def closed_on_nothing(self) -> bool:
        """Whether the fingers have closed on each other."""
        return self.state == GRIPPING and self.width < self._min + MET

    @property
    def is_open(self) -> bool:
        """Whether the fingers are fully open and at rest."""
        return self.state == STILL and self.width > self._open - MET

    @property
    def status(self) -> str:
        """Short description: the finger forces, if pressing, and the opening of the largest."""
        apart = f"{1e3 * self.width:.0f} of {1e3 * self._open:.0f} mm apart"
        if self.state in (CLOSING, *PRESSING):
            left, right = self.forces
            return f"fingers press with {left:.1f} and {right:.1f} N, {apart}"
        return f"fingers {apart}"

    def _check_width(self, width: float) -> None:
        low, high = self._min, self._open
        if not low - 1e-9 <= width <= high + 1e-9:
            raise GripperError(f"the gripper opens from {low:g} to {high:g} m, not {width:g} m")
