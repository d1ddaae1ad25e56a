"""Force control of two fingers on a held object."""

import math
from collections.abc import Mapping
from typing import Any

_FIRST = 2.0  # [N] force at the start of the first ramp
_DAMPING = 20.0  # [N s/m] damping of each finger, or
_SETTLING = 0.01  # [s] time constant of the damping, if this gives more
_STEP_SHARE = 0.3  # maximum synchronizing force, relative to the grip force
_FORCE_GAIN = 5.0  # [1/s] integral action on the mean of the measured forces
_TRIM_SHARE = 0.2  # maximum integral term relative to the grip force, or
_FRICTION_SHARE = 2.0  # relative to the dry friction, if this gives more


class Press:
    """Controls two fingers with one grip force, which changes smoothly, and synchronizes them.

    The synchronization preserves the position difference at the time of the grip: centring the
    object would slide it over its support. It only has to balance the object's weight and
    resistance along the closing direction.

    Args:
        friction: Dry friction of a finger; the integral term can balance it [N].
        mass: Effective mass of a finger that pushes an object [kg].
    """

    def __init__(self, friction: float = 0.0, mass: float = 0.0) -> None:
        self._friction = friction
        self._damping = max(_DAMPING, mass / _SETTLING)
        self.force = 0.0  # [N] of each finger
        self._ramp = (0.0, 0.0, 0.0)  # from [N], to [N], duration [s]
        self._time = 0.0  # [s] since the ramp began
        self._trim = 0.0  # [N] integral term of the force control
        self._offset = 0.0  # [m] desired position difference, first minus second finger

    def begin(self, offset: float) -> None:
        """Start pressing on an object.

        Args:
            offset: Position difference to preserve, first minus second finger [m].
        """
        self.force, self._trim, self._offset = _FIRST, 0.0, offset

    def change(self, force: float, duration: float) -> None:
        """Start a smooth change to another force [N] over a duration [s]."""
        self._ramp = (self.force, force, duration)
        self._time = 0.0

    def advance(self, dt: float, measured: float) -> bool:
        """Advance by a control step.

        Args:
            dt: Duration of the step [s].
            measured: Mean of the measured finger forces [N].

        Returns:
            Whether the change of the force is complete.
        """
        start, end, duration = self._ramp
        self._time += dt
        if self._time < duration:
            share = 0.5 - 0.5 * math.cos(math.pi * self._time / duration)
            self.force = start + (end - start) * share
            return False
        self.force = end
        bound = max(_TRIM_SHARE * end, _FRICTION_SHARE * self._friction)
        trim = self._trim + _FORCE_GAIN * (end - measured) * dt
        self._trim = min(max(trim, -bound), bound)
        return True

    def forces(
        self, stiffness: float, damping: float, difference: float, v1: float, v2: float
    ) -> tuple[float, float]:
        """Return the forces on the two fingers, negative to close [N].

        Args:
            stiffness: Stiffness of a finger's position loop [N/m].
            damping: Damping of a finger's position loop [N s/m].
            difference: Current position difference, first minus second finger [m].
            v1: Velocity of the first finger [m/s].
            v2: Velocity of the second finger [m/s].
        """
        most = _STEP_SHARE * self.force + 0.2
        step = 0.5 * (stiffness * (difference - self._offset) + damping * (v1 - v2))
        step = min(max(step, -most), most)
        f = -(self.force + self._trim)
        return f - step - self._damping * v1, f + step - self._damping * v2

    def get_state(self) -> dict[str, Any]:
        """Return the state as plain data."""
        return {
            "force": self.force,
            "ramp": list(self._ramp),
            "time": self._time,
            "trim": self._trim,
            "offset": self._offset,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state returned by ``get_state``."""
        start, end, duration = state["ramp"]
        self.force, self._ramp, self._time = state["force"], (start, end, duration), state["time"]
        self._trim, self._offset = state["trim"], state["offset"]
