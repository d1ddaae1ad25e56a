"""Use of limits and tracking error of motions."""

import numpy as np

from bt_manip.recording.report import CycleLimitUse
from bt_manip.robots import JointLimits


class MotionStatistics:
    """Maxima over control steps, updated in blocks of steps.

    Differences between steps (jerk, torque rate, tool speed) are also taken between blocks and
    between cycles.
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        """Initialise without steps.

        Args:
            limits: Limits that the fractions refer to.
            dt: Time between two steps [s].
        """
        self._limits = limits
        self._dt = dt
        # A joint without bounds has no use of its range.
        half_range = (limits.upper - limits.lower) / 2.0
        bounded = np.isfinite(half_range)
        centre = np.add(limits.upper, limits.lower, where=bounded, out=np.zeros_like(limits.upper))
        self._middle = centre / 2.0
        self._half_range = np.where(bounded, half_range, np.inf)
        self._last: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self.begin()

    def begin(self) -> None:
        """Reset the maxima; the last step is kept for differences."""
        self._use = np.zeros(5)  # position, velocity, acceleration, jerk, effort
        self.torque_rate = 0.0  # [N m/s]
        self.tool_speed = 0.0  # [m/s]
        self.tracking_error: float | None = None  # [rad]

    def update(
        self,
        *,
        q: np.ndarray,
        q_ref: np.ndarray,
        v_ref: np.ndarray,
        a_ref: np.ndarray,
        tau: np.ndarray,
        tool: np.ndarray,
        free: np.ndarray,
    ) -> None:
        """Add control steps.

        Args:
            q: Positions of the joints [rad].  # (n, nq)
            q_ref: Their references at the same times [rad].  # (n, nq)
            v_ref: Reference velocities [rad/s].  # (n, nq)
            a_ref: Reference accelerations [rad/s2].  # (n, nq)
            tau: Commanded torques [N m].  # (n, nq)
            tool: Position of the tool in the world [m].  # (n, 3)
            free: Whether gripper and payload touch nothing but each other.  # (n,)
        """
        if len(q) == 0:
            return
        if self._last is None:
            self._last = (a_ref[0], tau[0], tool[0])
        jerk, torque_rate, velocity = (
            np.diff(rows, axis=0, prepend=last[None]) / self._dt
            for rows, last in zip((a_ref, tau, tool), self._last, strict=True)
        )
        self._last = (a_ref[-1].copy(), tau[-1].copy(), tool[-1].copy())
        limits = self._limits
        used = (
            (q_ref - self._middle, self._half_range),
            (v_ref, limits.velocity),
            (a_ref, limits.acceleration),
            (jerk, limits.jerk),
            (tau, limits.effort),
        )
        self._use = np.maximum(self._use, [float(np.max(np.abs(x) / most)) for x, most in used])
        self.torque_rate = max(self.torque_rate, float(np.abs(torque_rate).max()))
        self.tool_speed = max(self.tool_speed, float(np.linalg.norm(velocity, axis=1).max()))
        if free.any():
            error = float(np.abs(q[free] - q_ref[free]).max())
            self.tracking_error = max(self.tracking_error or 0.0, error)

    @property
    def limit_use(self) -> CycleLimitUse:
        """Largest fraction of each kind of limit."""
        return CycleLimitUse(*(float(use) for use in self._use))
