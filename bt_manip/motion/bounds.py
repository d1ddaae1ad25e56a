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
