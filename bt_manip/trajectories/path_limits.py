"""Limits of the coordinates of a path: the joints of an arm, then further coordinates."""

import numpy as np

from bt_manip.robots import CONTROL_STEP, Limited, MotionLimits

TINY = 1e-9
"""Size of numbers that count as zero, against divisions by zero."""


class PathLimits:
    """Limits of velocity, acceleration and jerk along a path.

    Args:
        arm: Limits of the arm's motions.
        others: Velocity, acceleration and jerk of the coordinates after the joints.  # (3, k)

    Attributes:
        acceleration: Acceleration limits of all coordinates.  # (m,)
        jerk: Jerk limits of all coordinates.  # (m,)
    """

    def __init__(self, arm: MotionLimits, others: np.ndarray) -> None:
        self._arm, self._others = arm, others
        self.acceleration = np.append(arm.acceleration, others[1])
        self.jerk = np.append(arm.jerk, others[2])

    def speeds(self, x: np.ndarray, v: np.ndarray) -> list[Limited]:
        """Return all that velocity limits bound, as `MotionLimits.speeds`.

        Args:
            x: Coordinates.  # (n, m)
            v: Their velocities, or slopes of the path.  # (n, m)
        """
        nq = len(self._arm.velocity)
        speeds = self._arm.speeds(x[:, :nq], v[:, :nq])
        if self._others.size:
            speeds.append(Limited("coordinate {}", v[:, nq:], self._others[0]))
        return speeds

    def use(
        self, x: np.ndarray, velocity: np.ndarray, acceleration: np.ndarray
    ) -> tuple[float, float, float]:
        """Return the largest used fractions of the velocity, acceleration and jerk limits.

        Args:
            x: Coordinates at control steps.  # (n, m)
            velocity: Velocities at the same times.  # (n, m)
            acceleration: Accelerations at the same times, whose differences are the jerk.  # (n, m)
        """
        jerk = np.abs(np.diff(acceleration, axis=0)).max(axis=0) / (CONTROL_STEP * self.jerk)
        return (
            max(limited.use for limited in self.speeds(x, velocity)),
            float((np.abs(acceleration).max(axis=0) / self.acceleration).max()),
            float(jerk.max()),
        )
