"""Figures of the motion of one robot, from its control steps."""

from collections.abc import Iterable
from dataclasses import astuple
from typing import NamedTuple

import numpy as np

from bt_manip.record.report.run_report import CycleLimitUse, RobotCycle
from bt_manip.robots import JointLimits
from bt_manip.runner import StepBlock

BEFORE_PEAK = 0.1
"""Time before a tracking error in which its cause is looked for: four time constants of the
computed torque controller's default poles [s]."""


def limit_use(
    limits: JointLimits,
    q_ref: np.ndarray,
    v_ref: np.ndarray,
    a_ref: np.ndarray,
    jerk: np.ndarray,
    tau: np.ndarray,
) -> np.ndarray:
    """Return the largest fraction of each kind of limit that a joint uses in each control step.

    Args:
        limits: Limits that the fractions refer to.
        q_ref: Reference position [rad].  # (n, nq), as all others
        v_ref: Reference velocity [rad/s].
        a_ref: Reference acceleration [rad/s2].
        jerk: Reference jerk [rad/s3].
        tau: Torque [N m].

    Returns:
        A column for each field of `CycleLimitUse`.  # (n, 5)
    """
    # A joint without bounds has no use of its range.
    half_range = (limits.upper - limits.lower) / 2.0
    bounded = np.isfinite(half_range)
    centre = np.add(limits.upper, limits.lower, where=bounded, out=np.zeros_like(limits.upper))
    used = (
        (q_ref - centre / 2.0, np.where(bounded, half_range, np.inf)),
        (v_ref, limits.velocity_at(q_ref, v_ref)),
        (a_ref, limits.acceleration),
        (jerk, limits.jerk),
        (tau, limits.effort),
    )
    return np.stack([np.abs(x / most).max(axis=1) for x, most in used], axis=1)


class Peak(NamedTuple):
    """The largest tracking error, as in `TrackingPeak`."""

    error: float  # [rad]
    joint: int  # from 0
    time: float  # [s] simulated
    effort: float
    after_contact: float | None  # [s]


class StepFigures(NamedTuple):
    """Figures of each control step of a block."""

    error: np.ndarray
    """Tracking error: position minus reference [rad].  # (n, nq)"""
    free: np.ndarray
    """Whether it moved, grippers and the entities they hold touching only each other.  # (n,)"""
    use: np.ndarray
    """Largest fraction of each kind of limit, as in `CycleLimitUse`.  # (n, 5)"""


class MotionStatistics:
    """Maxima over control steps, updated in blocks of steps of any length.

    Differences between steps (jerk, torque rate, tool speed) are also taken between blocks and
    between cycles.

    Args:
        limits: Limits that the fractions refer to.
        dt: Time between two steps [s].
    """

    def __init__(self, limits: JointLimits, dt: float) -> None:
        self._limits = limits
        self._dt = dt
        self._last: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        self._recent = np.zeros((round(BEFORE_PEAK / dt), 2))  # use of effort, whether it touched
        self.begin()

    def begin(self) -> None:
        """Reset the maxima; the last step is kept for differences."""
        self._use = np.zeros(5)  # position, velocity, acceleration, jerk, effort
        self.torque_rate = 0.0  # [N m/s]
        self.tool_speed = 0.0  # [m/s]
        self.peak: Peak | None = None
        self.deflection = 0.0  # [rad]

    def update(self, block: StepBlock) -> StepFigures:
        """Update the maxima with control steps, at least one, and return the figures of each."""
        a_ref, tau, tool = block.a_ref, block.tau, block.tool
        if self._last is None:
            self._last = (a_ref[0], tau[0], tool[0])
        jerk, torque_rate, velocity = (
            np.diff(rows, axis=0, prepend=last[None]) / self._dt
            for rows, last in zip((a_ref, tau, tool), self._last, strict=True)
        )
        self._last = (a_ref[-1].copy(), tau[-1].copy(), tool[-1].copy())
        use = limit_use(self._limits, block.q_ref, block.v_ref, a_ref, jerk, tau)
        self._use = np.maximum(self._use, use.max(axis=0))
        self.torque_rate = max(self.torque_rate, float(np.abs(torque_rate).max()))
        speed = np.linalg.norm(velocity, axis=1).max()
        self.tool_speed = float(np.maximum(self.tool_speed, speed))  # NaN where it is unknown
        untouched = np.array([touch.free for touch in block.touches])
        free = untouched & block.v_ref.any(axis=1)
        signed = block.q - block.q_ref
        errors = np.abs(signed)
        error = errors.max(axis=1)
        recent = np.concatenate([self._recent, np.column_stack([use[:, -1], ~untouched])])
        if free.any():
            step = int(np.where(free, error, -1.0).argmax())
            if self.peak is None or error[step] > self.peak.error:
                before = recent[step + 1 : step + 1 + len(self._recent)]
                joint, time = int(errors[step].argmax()), float(block.t[step])
                self.peak = Peak(float(error[step]), joint, time, *self._preceding(before))
        self._recent = recent[len(block.touches) :]
        self.deflection = max(self.deflection, float(error[~free].max(initial=0.0)))
        return StepFigures(signed, free, use)

    def _preceding(self, before: np.ndarray) -> tuple[float, float | None]:
        """Return the largest use of effort, and the time since the last contact [s]."""
        touched = np.flatnonzero(before[:, 1])
        after = (len(before) - 1 - int(touched[-1])) * self._dt if len(touched) else None
        return float(before[:, 0].max()), after

    @property
    def tracking_error(self) -> float | None:
        """Largest tracking error in free motion [rad]."""
        return self.peak and self.peak.error

    @property
    def limit_use(self) -> CycleLimitUse:
        """Largest fraction of each kind of limit."""
        return CycleLimitUse(*(float(use) for use in self._use))


def combined(robots: Iterable[RobotCycle]) -> RobotCycle:
    """Return the figures of a cycle over all robots: maxima, sums, or the least grip force."""
    cycles = list(robots)
    limits = np.array([astuple(cycle.limits) for cycle in cycles]).max(axis=0)
    grips = [c.grip_force_n for c in cycles if c.grip_force_n is not None]
    worst = max(cycles, key=lambda cycle: cycle.max_tracking_error_rad or 0.0)
    return RobotCycle(
        picked=tuple(dict.fromkeys(name for cycle in cycles for name in cycle.picked)),
        grip_force_n=min(grips, default=None),
        max_tracking_error_rad=worst.max_tracking_error_rad,
        tracking_peak=worst.tracking_peak,
        max_deflection_rad=max(cycle.max_deflection_rad for cycle in cycles),
        limits=CycleLimitUse(*limits.tolist()),
        saturated_steps=sum(cycle.saturated_steps for cycle in cycles),
        max_torque_rate_nm_s=max(cycle.max_torque_rate_nm_s for cycle in cycles),
        max_tool_speed_m_s=max(cycle.max_tool_speed_m_s for cycle in cycles),
    )
