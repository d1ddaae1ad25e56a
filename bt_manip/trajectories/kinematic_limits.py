"""Limits of velocity, acceleration and jerk of the coordinates of a path."""

from typing import NamedTuple

import numpy as np

from bt_manip.robots import JointLimits, VelocityNearLimits

TINY = 1e-9
"""Size of numbers that count as zero, against divisions by zero."""


class KinematicLimits(NamedTuple):
    """Limits of each coordinate of a path: the joints, then further coordinates of the path."""

    velocity: np.ndarray  # (m,)
    acceleration: np.ndarray  # (m,)
    jerk: np.ndarray  # (m,)
    near: VelocityNearLimits | None = None  # lower velocity limits of the joints

    @classmethod
    def of_joints(cls, limits: JointLimits) -> "KinematicLimits":
        """Return the limits of the joints."""
        return cls(limits.velocity, limits.acceleration, limits.jerk, limits.near)

    def with_coordinate(
        self, velocity: float, acceleration: float, jerk: float
    ) -> "KinematicLimits":
        """Return the limits with those of one more coordinate appended."""
        return KinematicLimits(
            np.append(self.velocity, velocity),
            np.append(self.acceleration, acceleration),
            np.append(self.jerk, jerk),
            self.near,
        )

    def velocity_at(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the velocity limits at coordinates, in the directions of velocities.

        Args:
            x: Coordinates.  # (n, m)
            v: Velocities, of which the signs count.  # (n, m)
        """  # (n, m)
        limits = np.tile(self.velocity, (len(x), 1))
        if self.near is not None:
            nq = len(self.near.offset)
            bounds = self.near.bounds(x[:, :nq], v[:, :nq])
            limits[:, :nq] = np.minimum(limits[:, :nq], bounds)
        return limits

    def use(
        self, x: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray, step: float
    ) -> tuple[float, float, float]:
        """Return the largest used fractions of the velocity, acceleration and jerk limits.

        Args:
            x: Coordinates at equal time steps.  # (n, m)
            velocity: Velocities at the same times.  # (n, m)
            acceleration: Accelerations at the same times.  # (n, m)
            step: Time step [s]; the jerk is the difference of accelerations over it.
        """
        return (
            float((np.abs(velocity) / self.velocity_at(x, velocity)).max()),
            float((np.abs(acceleration).max(axis=0) / self.acceleration).max()),
            float((np.abs(np.diff(acceleration, axis=0)).max(axis=0) / (step * self.jerk)).max()),
        )
