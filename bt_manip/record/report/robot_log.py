"""Records of one robot in a run."""

from collections.abc import Callable, Iterable
from dataclasses import astuple
from typing import Any, NamedTuple

import numpy as np

from bt_manip.record.report.run_report import CycleLimitUse, RobotCycle, TrackingPeak
from bt_manip.robots import MotionLimits
from bt_manip.runner import StepBlock

BEFORE_PEAK = 0.1
"""Time before a tracking error in which its cause is looked for: four time constants of the
computed torque controller's default poles [s]."""


def limit_use(
    limits: MotionLimits,
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


class MotionStatistics:
    """Maxima over control steps, updated in blocks of steps.

    Differences between steps (jerk, torque rate, tool speed) are also taken between blocks and
    between cycles.
    """

    def __init__(self, limits: MotionLimits, dt: float) -> None:
        """Initialise without steps.

        Args:
            limits: Limits that the fractions refer to.
            dt: Time between two steps [s].
        """
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

    def update(self, block: StepBlock) -> None:
        """Update the maxima with control steps."""
        if not block.touches:
            return
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
        self.tool_speed = max(self.tool_speed, float(np.linalg.norm(velocity, axis=1).max()))
        untouched = np.array([touch.free for touch in block.touches])
        free = untouched & block.v_ref.any(axis=1)
        errors = np.abs(block.q - block.q_ref)
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


class RobotLog:
    """Computes the figures of a robot in each cycle.

    Attributes:
        name: The robot's name.
        statistics: Maxima over its control steps.
        grip: Least of the gripper's forces at the end of the last Grasp that held something [N],
            or None.
        picked: Names of the objects gripped in this cycle.
    """

    def __init__(self, cell: Any, robot: Any) -> None:
        """Bind to a robot.

        Args:
            cell: The `bt_manip.cell.Cell`.
            robot: The `bt_manip.runner.CommandedRobot`.
        """
        self.name = robot.name
        self._cell, self._robot = cell, robot
        self.statistics = MotionStatistics(robot.robot.limits, cell.dt)
        self.begin()

    def begin(self) -> None:
        """Start a cycle."""
        self._start = self._cell.time
        self.statistics.begin()
        self.grip: float | None = None
        self.picked: list[str] = []
        self._saturated_before = self._robot.controller.saturated_steps

    def grasped(self) -> None:
        """Record the grip force at the end of a Grasp, if it holds something."""
        if self.gripped():
            self.grip = min(self._robot.gripper.forces, default=None)

    def gripped(self) -> list[str]:
        """Record and return the objects that are gripped now: held by a closed gripper.

        As for behaviours, the force does not matter.
        """
        gripper = self._robot.gripper
        if gripper is None or not gripper.gripping:
            return []
        names = [name for name in gripper.held if self._cell.is_free(name)]
        self.picked += [name for name in names if name not in self.picked]
        return names

    def cycle(self, leaf_at: Callable[[float], str]) -> RobotCycle:
        """Return the figures of the cycle.

        Args:
            leaf_at: Returns the name of the action leaf that ran at a time of the cycle [s].
        """
        statistics = self.statistics
        return RobotCycle(
            picked=tuple(self.picked),
            grip_force_n=self.grip,
            max_tracking_error_rad=statistics.tracking_error,
            tracking_peak=self._tracking_peak(leaf_at),
            max_deflection_rad=statistics.deflection,
            limits=statistics.limit_use,
            saturated_steps=self._robot.controller.saturated_steps - self._saturated_before,
            max_torque_rate_nm_s=statistics.torque_rate,
            max_tool_speed_m_s=statistics.tool_speed,
        )

    def _tracking_peak(self, leaf_at: Callable[[float], str]) -> TrackingPeak | None:
        peak = self.statistics.peak
        if peak is None:
            return None
        time = round(peak.time - self._start, 6)
        joint = self._robot.robot.description.arm_joints[peak.joint]
        return TrackingPeak(joint, leaf_at(time), time, peak.effort, peak.after_contact)


def combined(robots: Iterable[RobotCycle]) -> dict[str, Any]:
    """Return the figures of a cycle over all robots, by the fields of `CycleReport`."""
    cycles = list(robots)
    limits = np.array([astuple(cycle.limits) for cycle in cycles]).max(axis=0)
    grips = [c.grip_force_n for c in cycles if c.grip_force_n is not None]
    worst = max(cycles, key=lambda cycle: cycle.max_tracking_error_rad or 0.0)
    return {
        "grip_force_n": min(grips, default=None),
        "max_tracking_error_rad": worst.max_tracking_error_rad,
        "tracking_peak": worst.tracking_peak,
        "max_deflection_rad": max(cycle.max_deflection_rad for cycle in cycles),
        "limits": CycleLimitUse(*limits.tolist()),
        "saturated_steps": sum(cycle.saturated_steps for cycle in cycles),
        "max_torque_rate_nm_s": max(cycle.max_torque_rate_nm_s for cycle in cycles),
        "max_tool_speed_m_s": max(cycle.max_tool_speed_m_s for cycle in cycles),
    }
