"""Limits of velocity, acceleration and jerk of the coordinates of a path."""

from typing import NamedTuple

import numpy as np

from bt_manip.robots import JointLimits


class KinematicLimits(NamedTuple):
    """Limits of each coordinate of a path: the joints, then further coordinates of the path."""

    velocity: np.ndarray  # (m,)
    acceleration: np.ndarray  # (m,)
    jerk: np.ndarray  # (m,)

    @classmethod
    def of_joints(cls, limits: JointLimits) -> "KinematicLimits":
        """Return the limits of the joints."""
        return cls(limits.velocity, limits.acceleration, limits.jerk)

    def with_coordinate(
        self, velocity: float, acceleration: float, jerk: float
    ) -> "KinematicLimits":
        """Return the limits with those of one more coordinate appended."""
        return KinematicLimits(
            np.append(self.velocity, velocity),
            np.append(self.acceleration, acceleration),
            np.append(self.jerk, jerk),
        )

    def use(
        self, velocity: np.ndarray, acceleration: np.ndarray, step: float
    ) -> tuple[float, float, float]:
        """Return the largest used fractions of the velocity, acceleration and jerk limits.

        Args:
            velocity: Velocities at equal time steps.  # (n, m)
            acceleration: Accelerations at the same times.  # (n, m)
            step: Time step [s]; the jerk is the difference of accelerations over it.
        """
        return (
            float((np.abs(velocity).max(axis=0) / self.velocity).max()),
            float((np.abs(acceleration).max(axis=0) / self.acceleration).max()),
            float((np.abs(np.diff(acceleration, axis=0)).max(axis=0) / (step * self.jerk)).max()),
        )
