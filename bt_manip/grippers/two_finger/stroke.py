"""Jerk-limited trajectory of a finger."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import ruckig

from bt_manip.robots import GripperError
from bt_manip.trajectories import MotionProfile

BORDER = 1e-6
"""Relative change of the start velocity if Ruckig has no profile for the exact value."""


class Motion(NamedTuple):
    """Desired position, velocity and acceleration of a finger."""

    s: float  # [m]
    v: float  # [m/s]
    a: float  # [m/s2]


class StrokeLimits(NamedTuple):
    """Motion limits of a finger."""

    speed: float  # [m/s]
    acceleration: float = 5.0  # [m/s2]
    jerk: float = 500.0  # [m/s3]


class Stroke:
    """A time-optimal trajectory to rest: at a target, or as soon as the limits allow.

    Args:
        start: Initial motion.
        target: Final position [m]; None to stop as soon as possible.
        limits: Motion limits.

    Raises:
        GripperError: If there is no such trajectory, e.g. with zero maximum speed.
    """

    def __init__(self, start: Motion, target: float | None, limits: StrokeLimits):
        self.start, self.target, self.limits = start, target, limits
        self.elapsed = 0.0
        task = ruckig.InputParameter(1)
        task.current_position = [start.s]
        task.current_velocity = [start.v]
        task.current_acceleration = [start.a]
        task.max_velocity = [limits.speed]
        task.max_acceleration = [limits.acceleration]
        task.max_jerk = [limits.jerk]
        if target is None:
            task.control_interface = ruckig.ControlInterface.Velocity
            task.target_velocity = [0.0]
        else:
            task.target_position = [target]
        trajectory = ruckig.Trajectory(1)
        try:
            try:
                result = ruckig.Ruckig(1).calculate(task, trajectory)
            except ruckig.RuckigError:  # the start is on the border between two kinds of profiles
                task.current_velocity = [start.v * (1.0 - BORDER)]
                result = ruckig.Ruckig(1).calculate(task, trajectory)
        except ruckig.RuckigError as error:
            raise GripperError(
                f"a finger cannot travel from {start} to {target}: {error}"
            ) from None
        if result != ruckig.Result.Working:
            raise GripperError(f"a finger cannot travel from {start} to {target} within {limits}")
        self._profile = MotionProfile.from_ruckig(trajectory.profiles[0][0], trajectory.duration)

    @property
    def done(self) -> bool:
        """Whether the trajectory has ended."""
        return self.elapsed >= self._profile.duration

    def advance(self, dt: float) -> Motion:
        """Advance by ``dt`` [s] and return the motion at the new time."""
        self.elapsed += dt
        return Motion(*self._profile.at(self.elapsed))

    def get_state(self) -> dict[str, Any]:
        """Return the stroke as plain data."""
        return {
            "start": list(self.start),
            "target": self.target,
            "limits": list(self.limits),
            "elapsed": self.elapsed,
        }

    @classmethod
    def from_state(cls, state: Mapping[str, Any]) -> "Stroke":
        """Restore a stroke from plain data; Ruckig recomputes it bit for bit."""
        stroke = cls(Motion(*state["start"]), state["target"], StrokeLimits(*state["limits"]))
        stroke.elapsed = state["elapsed"]
        return stroke
