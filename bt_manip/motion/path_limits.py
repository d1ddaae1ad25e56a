"""Bounds of a path parameter."""

from typing import NamedTuple


class PathLimits(NamedTuple):
    """Bounds of the path parameter's velocity, acceleration and jerk.

    A profile inside them keeps every joint inside its limits, everywhere on the path.
    """

    velocity: float
    acceleration: float
    jerk: float

    def scaled(self, time_scale: float = 1.0, acceleration: float = 1.0) -> "PathLimits":
        """Slow down: all in time, or accelerations and jerks only."""
        return PathLimits(
            self.velocity * time_scale,
            self.acceleration * time_scale**2 * acceleration,
            self.jerk * time_scale**3 * acceleration,
        )
