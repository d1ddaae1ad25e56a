"""A gripper of two fingers: positions while it travels, forces while it holds."""

import numpy as np
from dm_control import composer
from dm_control.composer.observation import observable

from bt_manip.robots import GripperError, Robot

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
from .stroke import StrokeLimits

_RELEASE = 0.04  # [s]
_STEADY_TIME = 0.05  # [s]


class TwoFingerGripperObservables(composer.Observables):
    """How far it is open, and how hard it presses."""

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
    """Opens and closes two fingers, and holds with a force."""

    def _build(self, robot: Robot, speed: float | None = None) -> None:
        """Prepare to control a robot's gripper.

        Args:
            robot: A robot with two fingers.
            speed: Speed of each finger unless a command says otherwise [m/s]; default: 0.1, or
                the greatest that the gripper has.

        Raises:
            RobotError: When the robot has no gripper, or its model and description do not fit.
            GripperError: When the gripper has no such speed.
        """
        super()._build(robot)
        self._speed = self._checked_speed(speed)
        self._reset()

    def _build_observables(self) -> TwoFingerGripperObservables:
        return TwoFingerGripperObservables(self)

    # Commands

    def open(self, speed: float | None = None) -> None:
        """Open all the way; what is held is let go softly first.

        Args:
            speed: Of each finger [m/s].
        """
        self.move(self._open, speed)

    def move(self, width: float, speed: float | None = None) -> None:
        """Move to an opening.

        Args:
            width: Distance between the fingers [m].
            speed: Of each finger [m/s].

        Raises:
            GripperError: When the gripper does not open or move so.
        """
        low, high = self._min, self._open
        if not low - 1e-9 <= width <= high + 1e-9:
            raise GripperError(f"the gripper opens from {low:g} to {high:g} m, not {width:g} m")
        self._limits = StrokeLimits(self._checked_speed(speed))
        self._target = 0.5 * width
        if self.state in PRESSING:
            self._change_force(RELEASING, 0.0, _RELEASE)
        else:
            self._travel(self._target)
            self.state = MOVING

    def close(self, force: float = 50.0, speed: float | None = None) -> None:
        """Close until both fingers press with a force, or meet.

        Args:
            force: Normal force of each finger [N].
            speed: Of each finger until one of them touches [m/s].

        Raises:
            GripperError: When the gripper has no such force or speed.
        """
        force = self.check_force(force)
        self._limits = StrokeLimits(self._checked_speed(speed))
        self._asked = force
        self._in_band = 0
        if self.state in PRESSING:
            self._change_force(GRIPPING, force, RAMP)
        else:
            self._slowed = False
            self._travel(0.5 * self._min)
            self.state = CLOSING

    def stop(self) -> None:
        """Brake the fingers; what is held stays held."""
        if self.state in (MOVING, CLOSING):
            self._travel(None)
            self.state = MOVING
        elif self.state == RELEASING:
            self._change_force(GRIPPING, self._asked, RAMP)

    # Questions

    @property
    def moving(self) -> bool:
        """Whether a command is still being carried out."""
        return self.state in (MOVING, CLOSING, RELEASING) or (
            self.state == GRIPPING and not (self.steady or self.closed_on_nothing)
        )

    @property
    def steady(self) -> bool:
        """Whether each finger has pressed with 95 to 120 % of the asked force for 50 ms."""
        return (
            self.state == GRIPPING
            and self._in_band * self._dt >= _STEADY_TIME - 1e-9
            and not self.closed_on_nothing
        )

    @property
    def closed_on_nothing(self) -> bool:
        """Whether the fingers have closed and met."""
        return self.state == GRIPPING and self.width < self._min + MET

    @property
    def is_open(self) -> bool:
        """Whether the fingers are all the way open, and still."""
        return self.state == STILL and self.width > self._open - MET

    @property
    def status(self) -> str:
        """How hard the fingers press, or how far they are open."""
        apart = f"{1e3 * self.width:.0f} mm apart"
        if self.state in (CLOSING, *PRESSING):
            left, right = self.forces
            return f"fingers press with {left:.1f} and {right:.1f} N, {apart}"
        return f"fingers {apart}"

    def _checked_speed(self, speed: float | None) -> float:
        if speed is None:
            return self._speed
        most = self._parameters.max_speed
        if not 0 < speed <= most:
            raise GripperError(f"a finger moves with up to {most:g} m/s, not {speed:g} m/s")
        return float(speed)
