"""Motion profiles of one coordinate: polynomials in time, piece by piece."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import ruckig

from bt_manip.exceptions import MotionError

MAX_DURATION = 600.0  # [s] of one motion: every control step of it is computed when it is planned

ScalarState = tuple[float, float, float]  # position, velocity, acceleration of one coordinate


class MotionProfile:
    """Position, velocity and acceleration over time; at rest at the end position afterwards.

    The jerk is constant in each segment. Unlike `ruckig.Trajectory` a profile can be stored.

    Attributes:
        segments: Start time, position, velocity, acceleration and jerk.  # (n, 5)
        duration: End of the last segment [s].
        end: Position from then on.
    """

    def __init__(self, segments: list[list[float]], duration: float, end: float) -> None:
        self.segments = segments = segments or [[0.0, end, 0.0, 0.0, 0.0]]
        self._starts = [segment[0] for segment in segments]
        table = np.array([*segments, [duration, end, 0.0, 0.0, 0.0]])
        self._times, self._coefficients = table[:, 0], table[:, 1:].T.copy()
        self._coefficients[2:] /= [[2.0], [6.0]]  # of the powers of time since the start
        self.duration = duration
        self.end = end

    @classmethod
    def from_ruckig(
        cls, profile: ruckig.Profile, duration: float, end: float | None = None
    ) -> "MotionProfile":
        """Convert one degree of freedom of a Ruckig trajectory.

        Args:
            profile: Ruckig's profile.
            duration: Duration of the whole trajectory, which may be longer [s].
            end: End position; by default that of the last segment.
        """
        segments = []
        t = 0.0
        for part in (profile.brake, profile, profile.accel):
            for dt, p, v, a, j in zip(part.t, part.p, part.v, part.a, part.j, strict=False):
                if dt > 0.0:
                    segments.append([t, p, v, a, j])
                    t += dt
        if end is None:  # Ruckig's velocity interface gives no end position
            start, p, v, a, j = segments[-1] if segments else (0.0, profile.p[0], 0.0, 0.0, 0.0)
            x = t - start
            end = p + x * (v + x * (a / 2.0 + x * j / 6.0))
        if duration > t:
            segments.append([t, end, 0.0, 0.0, 0.0])
        return cls(segments, duration, end)

    def at(self, t: float) -> ScalarState:
        """Return position, velocity and acceleration at one time [s]."""
        if t >= self.duration:
            return self.end, 0.0, 0.0
        start, p, v, a, j = self.segments[max(0, bisect_right(self._starts, t) - 1)]
        x = t - start
        return (
            p + x * (v + x * (a / 2.0 + x * j / 6.0)),
            v + x * (a + x * j / 2.0),
            a + x * j,
        )

    def sample(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return positions, velocities and accelerations at times [s]."""  # (n,) each
        index = np.maximum(self._times.searchsorted(times, side="right") - 1, 0)
        x = times - self._times[index]
        p, v, a, j = self._coefficients.take(index, axis=1)
        position = p + x * (v + x * (a + x * j))
        velocity = v + x * (2.0 * a + x * (3.0 * j))
        return position, velocity, 2.0 * a + x * (6.0 * j)

    def sample_along(
        self, evaluate: Callable[[np.ndarray], Sequence[np.ndarray]], times: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return coordinates x(s), velocities and accelerations, where s has this profile.

        Args:
            evaluate: Returns x and its first two derivatives by s.  # (n, m) each
            times: Times [s].  # (n,)
        """  # (n, m) each
        s, s_dot, s_ddot = self.sample(times)
        x, d1, d2 = evaluate(s)
        s_dot, s_ddot = s_dot[:, np.newaxis], s_ddot[:, np.newaxis]
        return x, d1 * s_dot, d2 * (s_dot * s_dot) + d1 * s_ddot

    def breakpoints(self) -> np.ndarray:
        """Return the start times of all segments and the end [s]."""
        return self._times.copy()

    def scaled(self, factor: float, end: float) -> "MotionProfile":
        """Return the profile with positions multiplied by a factor, and an exact end position."""
        segments = [[segment[0], *(factor * x for x in segment[1:])] for segment in self.segments]
        return MotionProfile(segments, self.duration, end)

    def slowed(self, factor: float) -> "MotionProfile":
        """Return the profile with its duration multiplied by a factor.

        Raises:
            MotionError: When the duration becomes longer than `MAX_DURATION`.
        """
        check_duration(factor * self.duration)
        c = factor
        rows = np.array(self.segments)
        rows[:, 0] *= c
        rows[:, 2:] /= [c, c**2, c**3]
        return MotionProfile(rows.tolist(), self.duration * c, self.end)

    def then(self, other: "MotionProfile") -> "MotionProfile":
        """Return the profile continued by another one, which starts in the state of its end."""
        t = self.duration
        later = [[t + segment[0], *segment[1:]] for segment in other.segments]
        return MotionProfile(self.segments + later, t + other.duration, other.end)

    def get_state(self) -> dict[str, Any]:
        """Return the profile as plain data."""
        return {"segments": self.segments, "duration": self.duration, "end": self.end}

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> "MotionProfile":
        """Restore a profile from plain data."""
        return cls([list(s) for s in state["segments"]], state["duration"], state["end"])


def check_duration(duration: float) -> None:
    """Check that a motion does not take too long, as at a speed near zero.

    Raises:
        MotionError: When it takes longer than `MAX_DURATION`.
    """
    if not duration <= MAX_DURATION:
        raise MotionError(
            f"the motion would take {duration:.3g} s at this speed and speed scale; "
            f"at most {MAX_DURATION:g} s are allowed",
            reason="target",
        )


def integrate_acceleration(
    start: ScalarState, times: np.ndarray, acceleration: np.ndarray
) -> np.ndarray:
    """Integrate an acceleration that is linear between times, exactly.

    Args:
        start: Initial position, velocity and (unused) acceleration.
        times: Increasing times from 0 on [s].  # (n,)
        acceleration: Accelerations at these times.  # (n,)

    Returns:
        Time, position, velocity, acceleration and jerk at each time; zero jerk at the last
        one.  # (n, 5)
    """
    dt = np.diff(times)
    jerk = np.diff(acceleration) / dt
    gained = 0.5 * dt * (acceleration[1:] + acceleration[:-1])
    velocity = start[1] + np.concatenate([[0.0], np.cumsum(gained)])
    moved = dt * (velocity[:-1] + dt * (acceleration[:-1] / 2.0 + dt * jerk / 6.0))
    position = start[0] + np.concatenate([[0.0], np.cumsum(moved)])
    return np.column_stack([times, position, velocity, acceleration, np.append(jerk, 0.0)])


def profile_to_position(
    start: ScalarState, target: float, limits: tuple[float, float, float]
) -> MotionProfile:
    """Plan the time-optimal motion to rest at a target position.

    Args:
        start: Initial position, velocity and acceleration.
        target: Final position.
        limits: Limits of velocity, acceleration and jerk.
    """
    unit = limits[1]
    motion = _scalar_input(start, limits, unit)
    motion.target_position = [target / unit]
    trajectory = _calculate(motion)
    profile = MotionProfile.from_ruckig(trajectory.profiles[0][0], trajectory.duration)
    return profile.scaled(unit, target)


def profile_to_velocity(
    start: ScalarState, velocity: float, limits: tuple[float, float]
) -> MotionProfile:
    """Plan the time-optimal change to a velocity, whatever the final position.

    Args:
        start: Initial position, velocity and acceleration.
        velocity: Final velocity.
        limits: Acceleration and jerk limits.
    """
    unit = limits[0]
    motion = _scalar_input(start, (np.inf, *limits), unit)
    motion.control_interface = ruckig.ControlInterface.Velocity
    motion.target_velocity = [velocity / unit]
    trajectory = _calculate(motion)
    profile = MotionProfile.from_ruckig(trajectory.profiles[0][0], trajectory.duration)
    return profile.scaled(unit, unit * profile.end)


def joint_profiles(
    start: tuple[np.ndarray, np.ndarray, np.ndarray],
    target: np.ndarray,
    velocity: np.ndarray,
    acceleration: np.ndarray,
    jerk: np.ndarray,
    final: tuple[np.ndarray, np.ndarray] | None = None,
    shortest: float = 0.0,
) -> list[MotionProfile]:
    """Plan the time-optimal motion of several joints that all arrive at the same time.

    Args:
        start: Initial positions, velocities and accelerations.  # (nq,) each
        target: Final positions [rad].  # (nq,)
        velocity: Limits [rad/s].  # (nq,)
        acceleration: Limits [rad/s2].  # (nq,)
        jerk: Limits [rad/s3].  # (nq,)
        final: Final velocities and accelerations; by default the joints come to rest.  # (nq,) each
        shortest: Shortest duration [s].
    """
    motion = _input(start, velocity, acceleration, jerk)
    motion.minimum_duration = shortest or None
    motion.target_position = [float(x) for x in target]
    if final is not None:
        motion.target_velocity, motion.target_acceleration = (x.tolist() for x in final)
    trajectory = _calculate(motion)
    return [
        MotionProfile.from_ruckig(profile, trajectory.duration, float(end))
        for profile, end in zip(trajectory.profiles[0], target, strict=True)
    ]


def velocity_profiles(
    start: tuple[np.ndarray, np.ndarray, np.ndarray],
    velocity: np.ndarray,
    duration: float,
    acceleration: np.ndarray,
    jerk: np.ndarray,
) -> list[MotionProfile]:
    """Plan the change of several joints to velocities, and then to rest as soon as possible.

    Args:
        start: Initial positions, velocities and accelerations.  # (nq,) each
        velocity: Velocities that all reach at the same time [rad/s].  # (nq,)
        duration: Time until then [s]; longer where the limits require it.
        acceleration: Limits [rad/s2].  # (nq,)
        jerk: Limits [rad/s3].  # (nq,)
    """
    zero = np.zeros_like(velocity)
    parts = []
    for target, shortest in ((velocity, duration), (zero, 0.0)):
        motion = _input(start, np.full_like(velocity, np.inf), acceleration, jerk)
        motion.control_interface = ruckig.ControlInterface.Velocity
        motion.target_velocity, motion.minimum_duration = target.tolist(), shortest or None
        trajectory = _calculate(motion)
        d = trajectory.duration
        parts.append([MotionProfile.from_ruckig(p, d) for p in trajectory.profiles[0]])
        start = np.array([profile.end for profile in parts[-1]]), velocity, zero
    return [first.then(second) for first, second in zip(*parts, strict=True)]


def _scalar_input(start: ScalarState, limits: tuple[float, float, float], unit: float) -> Any:
    """Return Ruckig's input in units of the acceleration limit: its tolerances are absolute."""
    state = tuple([x / unit] for x in start)
    return _input(state, *([limit / unit] for limit in limits))


def _input(start: Any, velocity: Any, acceleration: Any, jerk: Any) -> Any:
    # Never set intermediate_positions: Ruckig would ask a service on the network.
    motion = ruckig.InputParameter(len(start[0]))
    motion.current_position = [float(x) for x in start[0]]
    motion.current_velocity = [float(x) for x in start[1]]
    motion.current_acceleration = [float(x) for x in start[2]]
    motion.max_velocity = [float(x) for x in velocity]
    motion.max_acceleration = [float(x) for x in acceleration]
    motion.max_jerk = [float(x) for x in jerk]
    motion.synchronization = ruckig.Synchronization.Time
    return motion


def _calculate(motion: Any) -> Any:
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
