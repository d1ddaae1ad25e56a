"""Motion in one dimension with a jerk that is constant or changes evenly, piece by piece."""

from bisect import bisect_right
from typing import Any

import numpy as np
import ruckig

from bt_manip.exceptions import MotionError

LONGEST = 600.0  # [s] of what is driven at once: every control step of it is looked at


class JerkProfile:
    """Position, velocity and acceleration over time; afterwards at rest at the end.

    Plain numbers, unlike `ruckig.Trajectory`, which cannot be stored.
    """

    def __init__(self, segments: list[list[float]], duration: float, end: float) -> None:
        """Make a profile.

        Args:
            segments: Start time, position, velocity, acceleration and jerk of each, and how fast
                the jerk changes where it does.  # (n, 5) or (n, 6)
            duration: When the last one ends [s].
            end: Position from then on.
        """
        if not segments:
            segments = [[0.0, end, 0.0, 0.0, 0.0, 0.0]]
        elif len(segments[0]) < 6:
            segments = [[*segment, 0.0] for segment in segments]
        self._segments = segments
        self._starts = [segment[0] for segment in self._segments]
        at_rest = [duration, end, 0.0, 0.0, 0.0, 0.0]
        table = np.array([*self._segments, at_rest])
        self._since, self._rows = table[:, 0], table[:, 1:].T.copy()
        self._rows[2:] /= [[2.0], [6.0], [24.0]]  # what multiplies powers of the time since then
        self.duration = duration
        self.end = end

    @property
    def segments(self) -> list[list[float]]:
        """Start time, position, velocity, acceleration, jerk and its change."""  # (n, 6)
        return self._segments

    @classmethod
    def from_ruckig(cls, profile: ruckig.Profile, duration: float, end: float | None = None) -> Any:
        """Take one degree of freedom out of a computed trajectory.

        Args:
            profile: Its profile.
            duration: Of the whole trajectory, which may be longer [s].
            end: Where it ends; where the profile does by default.
        """
        segments = []
        t = 0.0
        for part in (profile.brake, profile, profile.accel):
            for dt, p, v, a, j in zip(part.t, part.p, part.v, part.a, part.j, strict=False):
                if dt > 0.0:
                    segments.append([t, p, v, a, j])
                    t += dt
        if end is None:  # Ruckig gives no end to what has no target
            start, p, v, a, j = segments[-1] if segments else (0.0, profile.p[0], 0.0, 0.0, 0.0)
            x = t - start
            end = p + x * (v + x * (a / 2.0 + x * j / 6.0))
        if duration > t:
            segments.append([t, end, 0.0, 0.0, 0.0])
        return cls(segments, duration, end)

    def sample(self, t: float) -> tuple[float, float, float]:
        """Give position, velocity and acceleration at a time [s]."""
        if t >= self.duration:
            return self.end, 0.0, 0.0
        start, p, v, a, j, k = self._segments[max(0, bisect_right(self._starts, t) - 1)]
        x = t - start
        return (
            p + x * (v + x * (a / 2.0 + x * j / 6.0 + x * x * k / 24.0)),
            v + x * (a + x * j / 2.0 + x * x * k / 6.0),
            a + x * j + x * x * k / 2.0,
        )

    def table(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Give positions, velocities and accelerations at many times."""  # (n,), (n,), (n,)
        index = np.maximum(self._since.searchsorted(times, side="right") - 1, 0)
        x = times - self._since[index]
        p, v, a, j, k = self._rows.take(index, axis=1)
        position = p + x * (v + x * (a + x * (j + x * k)))
        velocity = v + x * (2.0 * a + x * (3.0 * j + x * (4.0 * k)))
        return position, velocity, 2.0 * a + x * (6.0 * j + x * (12.0 * k))

    def corners(self) -> np.ndarray:
        """Give the times when the jerk changes."""
        return self._since.copy()

    def times(self, factor: float, end: float | None = None) -> "JerkProfile":
        """Do the same in another unit; where it ends exactly may be known better."""
        segments = [[segment[0], *(factor * x for x in segment[1:])] for segment in self._segments]
        return JerkProfile(segments, self.duration, factor * self.end if end is None else end)

    def slowed(self, factor: float) -> "JerkProfile":
        """Do the same in a time longer by a factor.

        Raises:
            MotionError: When it would take too long.
        """
        check_duration(factor * self.duration)
        c = factor
        segments = [
            [t * c, p, v / c, a / c**2, j / c**3, k / c**4] for t, p, v, a, j, k in self._segments
        ]
        return JerkProfile(segments, self.duration * c, self.end)

    def get_state(self) -> dict[str, Any]:
        """Give the profile as plain data."""
        return {"segments": self._segments, "duration": self.duration, "end": self.end}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> "JerkProfile":
        """Make a profile from plain data."""
        return cls([list(s) for s in state["segments"]], state["duration"], state["end"])


def check_duration(duration: float) -> None:
    """Refuse what would take too long, as at a speed that is nearly nought.

    Raises:
        MotionError: When it takes longer than `LONGEST`.
    """
    if not duration <= LONGEST:
        raise MotionError(
            f"the motion would take {duration:.3g} s at this speed and pace; "
            f"{LONGEST:g} s are the most",
            reason="target",
        )


def reach_profile(
    start: tuple[float, float, float],
    target: float,
    limits: tuple[float, float, float],
) -> JerkProfile:
    """Plan the fastest motion to rest at a target.

    Args:
        start: Position, velocity, acceleration.
        target: Position at the end.
        limits: Of velocity, acceleration, jerk.
    """
    unit = limits[1]
    motion = _scalar_input(start, limits, unit)
    motion.target_position = [target / unit]
    trajectory = calculate(motion)
    profile = JerkProfile.from_ruckig(trajectory.profiles[0][0], trajectory.duration)
    return profile.times(unit, target)


def brake_profile(
    start: tuple[float, float, float], limits: tuple[float, float, float]
) -> JerkProfile:
    """Plan the fastest motion to rest, wherever that is."""
    return ramp_profile(start, 0.0, limits[1:])


def ramp_profile(
    start: tuple[float, float, float], velocity: float, limits: tuple[float, float]
) -> JerkProfile:
    """Plan the fastest change to a velocity, wherever that ends.

    Args:
        start: Position, velocity, acceleration.
        velocity: At the end.
        limits: Of acceleration and jerk.
    """
    unit = limits[0]
    bound = max(abs(start[1]), abs(velocity), 1e-6)
    motion = _scalar_input(start, (bound, *limits), unit)
    motion.control_interface = ruckig.ControlInterface.Velocity
    motion.target_velocity = [velocity / unit]
    trajectory = calculate(motion)
    return JerkProfile.from_ruckig(trajectory.profiles[0][0], trajectory.duration).times(unit)


def joint_profiles(
    start: tuple[np.ndarray, np.ndarray, np.ndarray],
    target: np.ndarray | None,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    jerk: np.ndarray,
) -> list[JerkProfile]:
    """Plan the fastest motion of several joints that all come to rest at the same time.

    Args:
        start: Positions, velocities and accelerations.  # (nq,) each
        target: Positions at the end; None brakes, wherever that ends.  # (nq,)
        velocity: Limits [rad/s].  # (nq,)
        acceleration: Limits [rad/s2].  # (nq,)
        jerk: Limits [rad/s3].  # (nq,)
    """
    n = len(start[0])
    motion = _input(n, start, velocity, acceleration, jerk)
    if target is None:
        motion.control_interface = ruckig.ControlInterface.Velocity
    else:
        motion.target_position = list(target)
    trajectory = calculate(motion)
    ends = [None] * n if target is None else [float(x) for x in target]
    return [
        JerkProfile.from_ruckig(profile, trajectory.duration, end)
        for profile, end in zip(trajectory.profiles[0], ends, strict=True)
    ]


def _scalar_input(
    start: tuple[float, float, float], limits: tuple[float, float, float], unit: float
) -> Any:
    """Measure in units of the acceleration limit: Ruckig's tolerances are absolute."""
    state = tuple([x / unit] for x in start)
    return _input(1, state, *([limit / unit] for limit in limits))


def _input(n: int, start: Any, velocity: Any, acceleration: Any, jerk: Any) -> Any:
    # Never set intermediate_positions: Ruckig would ask a service on the network.
    motion = ruckig.InputParameter(n)
    motion.current_position = [float(x) for x in start[0]]
    motion.current_velocity = [float(x) for x in start[1]]
    motion.current_acceleration = [float(x) for x in start[2]]
    motion.max_velocity = [float(x) for x in velocity]
    motion.max_acceleration = [float(x) for x in acceleration]
    motion.max_jerk = [float(x) for x in jerk]
    motion.synchronization = ruckig.Synchronization.Time
    return motion


def calculate(motion: Any) -> Any:
    """Let Ruckig plan.

    Raises:
        MotionError: When it finds no trajectory.
    """
    trajectory = ruckig.Trajectory(motion.degrees_of_freedom)
    try:
        result = ruckig.Ruckig(motion.degrees_of_freedom).calculate(motion, trajectory)
    except (ruckig.RuckigError, ValueError) as error:  # the latter for results without a name
        raise MotionError(f"no trajectory was found: {error}", reason="limits") from error
    if result not in (ruckig.Result.Working, ruckig.Result.Finished):
        raise MotionError(f"no trajectory was found: {result}", reason="limits")
    return trajectory
