"""The force of two fingers on what is between them."""

import math
from collections.abc import Mapping
from typing import Any

_FIRST = 2.0  # [N] force that the first ramp begins with
_DAMPING = 20.0  # [N s/m] of each finger
_STEP_SHARE = 0.3  # of the force: the most that keeping in step takes from a finger
_FORCE_GAIN = 5.0  # [1/s] integral action on the mean of the measured forces
_TRIM_SHARE = 0.2  # of the force: the most that the integral adds


class Press:
    """Drives two fingers with one force, which changes softly, and keeps them in step.

    What keeps them in step leaves the difference that they had when the object was gripped:
    centring it then would rub it on whatever it stands on. It only has to carry what the object
    weighs and resists along the fingers.
    """

    def __init__(self) -> None:
        """Press with nothing."""
        self.force = 0.0  # [N] of each finger
        self._ramp = (0.0, 0.0, 0.0)  # from [N], to [N], duration [s]
        self._time = 0.0  # [s] since the ramp began
        self._trim = 0.0  # [N] that the measured force was short of
        self._offset = 0.0  # [m] by which the first finger is further out

    def begin(self, offset: float) -> None:
        """Begin to press on an object.

        Args:
            offset: By how much the first finger is further out than the second [m].
        """
        self.force, self._trim, self._offset = _FIRST, 0.0, offset

    def change(self, force: float, duration: float) -> None:
        """Let the force change to another one, softly [N], [s]."""
        self._ramp = (self.force, force, duration)
        self._time = 0.0

    def advance(self, dt: float, measured: float) -> bool:
        """Go on by a control step.

        Args:
            dt: Duration of the step [s].
            measured: Mean of the forces that the fingers felt [N].

        Returns:
            Whether the force has arrived where it was asked to be.
        """
        start, end, duration = self._ramp
        self._time += dt
        if self._time < duration:
            share = 0.5 - 0.5 * math.cos(math.pi * self._time / duration)
            self.force = start + (end - start) * share
            return False
        self.force = end
        bound = _TRIM_SHARE * end
        trim = self._trim + _FORCE_GAIN * (end - measured) * dt
        self._trim = min(max(trim, -bound), bound)
        return True

    def forces(
        self, stiffness: float, damping: float, difference: float, v1: float, v2: float
    ) -> tuple[float, float]:
        """Give the forces of the two motors, closing ones being negative [N].

        Args:
            stiffness: Of a finger's position loop [N/m].
            damping: Of a finger's position loop [N s/m].
            difference: By how much the first finger is further out now [m].
            v1: Velocity of the first finger [m/s].
            v2: Velocity of the second finger [m/s].
        """
        most = _STEP_SHARE * self.force + 0.2
        step = 0.5 * (stiffness * (difference - self._offset) + damping * (v1 - v2))
        step = min(max(step, -most), most)
        f = -(self.force + self._trim)
        return f - step - _DAMPING * v1, f + step - _DAMPING * v2

    def get_state(self) -> dict[str, Any]:
        """Give everything as plain data."""
        return {
            "force": self.force,
            "ramp": list(self._ramp),
            "time": self._time,
            "trim": self._trim,
            "offset": self._offset,
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take everything back."""
        start, end, duration = state["ramp"]
        self.force, self._ramp, self._time = state["force"], (start, end, duration), state["time"]
        self._trim, self._offset = state["trim"], state["offset"]
