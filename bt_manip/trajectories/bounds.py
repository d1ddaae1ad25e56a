"""What the coordinates of a path may do."""

from typing import NamedTuple

import numpy as np

from bt_manip.robots import JointLimits


class Bounds(NamedTuple):
    """Limits of each coordinate of a path: joints first, then what it carries behind them."""

    velocity: np.ndarray  # (m,)
    acceleration: np.ndarray  # (m,)
    jerk: np.ndarray  # (m,)

    @classmethod
    def of_joints(cls, limits: JointLimits) -> "Bounds":
        """Take the joints' limits."""
        return cls(limits.velocity, limits.acceleration, limits.jerk)

    def and_also(self, velocity: float, acceleration: float, jerk: float) -> "Bounds":
        """Append a coordinate."""
        return Bounds(
            np.append(self.velocity, velocity),
            np.append(self.acceleration, acceleration),
            np.append(self.jerk, jerk),
        )

    def use(
        self, velocity: np.ndarray, acceleration: np.ndarray, step: float
    ) -> tuple[float, float, float]:
        """Give the largest fractions of velocity, acceleration and jerk that are used.

        Args:
            velocity: At equal steps of time.  # (n, m)
            acceleration: At the same; its differences are the jerk.  # (n, m)
            step: The time between them [s].
        """
        return (
            float((np.abs(velocity) / self.velocity).max()),
            float((np.abs(acceleration) / self.acceleration).max()),
            float((np.abs(np.diff(acceleration, axis=0)) / (step * self.jerk)).max()),
        )
