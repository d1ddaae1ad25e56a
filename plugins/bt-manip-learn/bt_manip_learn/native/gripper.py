"""A two-finger gripper controlled by MuJoCo's actuators."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from dm_control import mjcf

from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import GripperError, Robot

from .feedback import add_feedback

STILL, MOVING, GRIPPING = "still", "moving", "gripping"
"""States of the fingers."""

_POLE = 150.0  # [rad/s] both poles of a finger's position loop
_BEYOND = 1.5  # [grip forces] of the position loop at the reference beyond the closed fingers
_SETTLING = 0.05  # [s] after which a grip in the band is steady
_BAND = (0.90, 1.20)  # mean finger force relative to the commanded force
_TOLERANCE = 1e-3  # [m] of the opening
_SYNCHRONY = (0.005, 1.0)  # [s, -] time constant and damping ratio of the fingers' coupling


class NativeTwoFingerGripper(TwoFingerGripper):
    """A gripper with two sliding fingers, whose position loops are part of the model.

    The reference of the fingers moves at a constant speed, and beyond the object when closing. The
    grip force is the force range of the actuators. The fingers are coupled by a constraint, so that
    a held object cannot slip along the closing direction. There is no feedback in Python: control
    signals depend on the last command only.
    """

    kind = "native_two_finger"

    def _build(self, robot: Robot) -> None:
        """Put the position loops into the robot's model.

        Raises:
            RobotError: If the robot has no gripper, or its model and description do not match.
            GripperError: If the fingers do not slide.
        """
        self._start = self._aim = self._rate = 0.0
        self._signals: np.ndarray | None = None
        self._index = 0
        super()._build(robot)
        mechanism = self.mechanism
        if mechanism.travel.mass or len(mechanism.actuators) != 2:
            raise GripperError(
                f"robot '{robot.description.name}': the simulator's own control moves fingers on "
                "slides, one motor each, and these follow a mechanism: choose another controller "
                "than 'native_pd'"
            )
        (b1, a1), (b2, a2) = mechanism.travel.polynomials
        self._b, self._a = np.array([b1, b2]), np.array([a1, a2])
        dofs = [robot.alone.joint(joint.full_identifier).dofadr[0] for joint in mechanism.joints]
        mass = float(robot.alone.dof_M0[dofs].mean())
        added = 2.0 * mass * _POLE - float(robot.alone.dof_damping[dofs].mean())
        self._k, self._d = mass * _POLE**2, max(added, 0.0)
        slopes = self._a**2
        for motor, effort in zip(mechanism.actuators, self._efforts().tolist(), strict=True):
            motor.forcerange = [-effort, effort]  # initial value: a compiled model is reused
        mechanism.actuators = add_feedback(mechanism.actuators, self._k * slopes, self._d * slopes)
        first, second = mechanism.joints
        robot.mjcf_model.equality.add(
            "joint", name="finger_synchrony", joint1=first, joint2=second, solref=_SYNCHRONY,
            polycoef=[(b2 - b1) / a1, a2 / a1],
        )  # fmt: skip

    # Commands

    def move(self, width: float) -> None:
        """Move to an opening [m].

        Raises:
            GripperError: If the gripper cannot reach this opening.
        """
        self._check_width(width)
        self._go(0.5 * width)
        self.state = MOVING

    def close(self, force: float = 50.0) -> None:
        """Close until both fingers press with a force [N] each, or touch each other.

        Raises:
            GripperError: If the gripper cannot reach this force.
        """
        self._asked = self.check_force(force)
        self._limit_force()
        self._go(0.5 * self._min - _BEYOND * force / self._k)
        self.state = GRIPPING

    def stop(self) -> None:
        """Stop the fingers; a held object stays held."""
        if self.state == MOVING:
            self._go(self._reference)

    # Measurements

    @property
    def steady(self) -> bool:
        """Whether the fingers press with the commanded force, with references beyond the object."""
        if self.state != GRIPPING or self.closed_on_nothing:
            return False
        lag = self.width - 2.0 * self._reference
        low, high = (share * self._asked for share in _BAND)
        saturated = 2.0 * (self._asked / self._k + self._speed * _SETTLING)
        return lag > saturated and low <= 0.5 * sum(self.forces) <= high

    @property
    def gripping(self) -> bool:
        """Whether its last command was to close."""
        return self.state == GRIPPING

    @property
    def is_open(self) -> bool:
        """Whether the reference of the fingers is at the opening, and at rest."""
        return self.state == STILL and self._reference > 0.5 * (self._open - _TOLERANCE)

    # Composer's hooks

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model."""
        super().after_compile(physics, random_state)
        self._ctrl = physics.data.ptr.ctrl
        self._ranges = physics.model.ptr.actuator_forcerange
        self._limit_force()

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Reset, with the fingers open."""
        super().initialize_episode(physics, random_state)
        self._limit_force()

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the fingers for the next step."""
        signals = self._planned()
        self._ctrl[self.mechanism.ctrl_adr] = signals[min(self._index, len(signals) - 1)]

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Advance the reference."""
        self.advance(1)

    # Batches

    def signals(self, steps: int) -> np.ndarray:
        """Return the control signals of the next steps, and advance by them [N]."""  # (n, 2)
        planned = self._planned()
        rows = planned[np.minimum(self._index + np.arange(steps), len(planned) - 1)]
        self.advance(steps)
        return rows

    def driven(self) -> tuple[Any, ...]:
        """Return the reference and the measurements, for `drive`."""
        return (
            self.state, self._asked, self._start, self._aim, self._rate, self._index,
            self._signals, self._forces, self._touched,
        )  # fmt: skip

    def drive(self, driven: tuple[Any, ...]) -> None:
        """Set reference and measurements from another episode of the same robot."""
        (
            self.state, self._asked, self._start, self._aim, self._rate, self._index,
            self._signals, self._forces, self._touched,
        ) = driven  # fmt: skip

    def advance(self, steps: int) -> None:
        """Advance the reference by a number of steps, and discard the measurements."""
        self._forces = self._touched = None
        self._index += steps
        if self.state == MOVING and self._index >= len(self._planned()) - 1:
            self.state = STILL

    # Internal

    @property
    def _reference(self) -> float:
        """Commanded distance of each finger from the centre [m]."""
        return float(self._along(min(self._index, self._duration)))

    @property
    def _duration(self) -> int:
        """Steps from the last command until the reference rests."""
        return int(np.ceil(abs(self._aim - self._start) / (self._rate * self._dt)))

    def _along(self, steps: Any) -> Any:
        """Return the reference some steps after the last command [m]."""
        way = self._aim - self._start
        return self._start + np.sign(way) * np.minimum(steps * (self._rate * self._dt), abs(way))

    def _planned(self) -> np.ndarray:
        """Return the control signals from the last command to rest [N]."""  # (n, 2)
        if self._signals is None:
            s = self._along(np.arange(self._duration + 1))
            v = np.full_like(s, np.sign(self._aim - self._start) * self._rate)
            v[-1] = 0.0
            a, b = self._a, self._b
            self._signals = a * (self._k * (s[:, np.newaxis] - b) + self._d * v[:, np.newaxis])
        return self._signals

    def _go(self, aim: float) -> None:
        self._start, self._aim, self._rate = self._reference, aim, self._speed
        self._signals, self._index = None, 0

    def _limit_force(self) -> None:
        effort = self._efforts()
        self._ranges[self.mechanism.ctrl_adr] = np.stack([-effort, effort], axis=1)

    def _efforts(self) -> np.ndarray:
        """Return the maximum efforts of the motors for the commanded grip force [N]."""  # (2,)
        return np.abs(self._a) * self._asked

    def _reset(self) -> None:
        super()._reset()
        self._asked = self.default_force()
        self._start = self._aim = 0.5 * self._open
        self._rate, self._signals, self._index = self._speed, None, 0

    # State

    def get_state(self) -> dict[str, Any]:
        """Return the state kept between steps, as plain data."""
        ramp = [self._start, self._aim, self._rate, self._index]
        return {**super().get_state(), "ramp": ramp}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state returned by ``get_state``."""
        super().set_state(state)
        self._start, self._aim, self._rate, self._index = state["ramp"]
        self._signals = None
        self._limit_force()
