"""Trajectories: the configuration, velocity and acceleration of all joints over time."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import CONTROL_STEP, MotionLimits

from .motion_profile import MotionProfile, ScalarState, check_duration
from .path_limits import PathLimits
from .paths import Path, path_from_state

Samples = tuple[np.ndarray, np.ndarray, np.ndarray]  # q, v, a: (n, nq) each


class Trajectory(Protocol):
    """Configuration, velocity and acceleration over time; at rest from its end on.

    Attributes:
        duration: Time until it is at rest [s].
        end: Configuration at the end [rad].  # (nq,)
    """

    duration: float
    end: np.ndarray

    def sample(self, times: np.ndarray) -> Samples:
        """Return q, v and a at the given times [s]."""

    def breakpoints(self) -> np.ndarray:
        """Return the times at which the jerk may be discontinuous [s]."""

    def get_state(self) -> dict[str, Any]:
        """Return the trajectory as plain data."""


def sample_times(duration: float, step: float) -> np.ndarray:
    """Return the times of all steps from 0 to the first one after the end [s].

    Raises:
        MotionError: When the duration is longer than `MAX_DURATION`.
    """
    check_duration(duration)
    return step * np.arange(int(np.ceil(duration / step - 1e-9)) + 2)


class JointTrajectory:
    """One motion profile per joint, all of the same duration (time-synchronized)."""

    def __init__(self, profiles: Sequence[MotionProfile]) -> None:
        self._profiles = list(profiles)
        self.duration = max(profile.duration for profile in profiles)
        self.end = np.array([profile.end for profile in profiles])

    def sample(self, times: np.ndarray) -> Samples:
        """Return q, v and a at the given times [s]."""
        columns = [profile.sample(times) for profile in self._profiles]
        q, v, a = (np.stack(rows, axis=1) for rows in zip(*columns, strict=True))
        return q, v, a

    def breakpoints(self) -> np.ndarray:
        """Return the times at which the jerk may be discontinuous [s]."""
        return np.unique(np.concatenate([profile.breakpoints() for profile in self._profiles]))

    def get_state(self) -> dict[str, Any]:
        """Return the trajectory as plain data."""
        return {"kind": "joints", "profiles": [profile.get_state() for profile in self._profiles]}


class PathTrajectory:
    """A path with a motion profile of its path parameter s(t)."""

    def __init__(self, path: Path, profile: MotionProfile) -> None:
        self.path, self.profile = path, profile
        self.duration = profile.duration
        self.end = path.end
        if profile.end != 1.0:
            self.end = path.evaluate(np.array([profile.end]), 0)[0][0, : path.nq]

    def sample_coordinates(self, times: np.ndarray) -> Samples:
        """Return all coordinates of the path with their time derivatives."""  # (n, m) each
        return self.profile.sample_along(self.path.evaluate, times)

    def kinematic_use(self, limits: MotionLimits) -> tuple[float, float, float]:
        """Return the largest fractions of velocity, acceleration and jerk limits that are used."""
        samples = self.sample_coordinates(sample_times(self.duration, CONTROL_STEP))
        return PathLimits(limits, self.path.limits).use(*samples)

    def sample(self, times: np.ndarray) -> Samples:
        """Return q, v and a at the given times [s]."""
        q, v, a = (x[:, : self.path.nq] for x in self.sample_coordinates(times))
        q[times >= self.duration] = self.end
        return q, v, a

    def breakpoints(self) -> np.ndarray:
        """Return the times at which the jerk may be discontinuous [s]."""
        return self.profile.breakpoints()

    def get_state(self) -> dict[str, Any]:
        """Return the trajectory as plain data."""
        return {
            "kind": "path",
            "path": self.path.get_state(),
            "profile": self.profile.get_state(),
        }


class SequenceTrajectory:
    """Trajectories one after the other, each starting at rest at the end of the previous one."""

    def __init__(self, parts: Sequence[Trajectory]) -> None:
        self.parts = list(parts)
        self._starts = np.concatenate([[0.0], np.cumsum([part.duration for part in parts])])
        self.duration = float(self._starts[-1])
        self.end = self.parts[-1].end

    def active(self, t: float) -> tuple[Trajectory, float]:
        """Return the part at a time [s], and the time since the start of that part [s]."""
        i = min(int(np.searchsorted(self._starts, t, side="right")) - 1, len(self.parts) - 1)
        return self.parts[i], t - float(self._starts[i])

    def sample(self, times: np.ndarray) -> Samples:
        """Return q, v and a at the given times [s]."""
        q, v, a = (np.empty((len(times), len(self.end))) for _ in range(3))
        index = np.searchsorted(self._starts, times, side="right") - 1
        index = np.minimum(index, len(self.parts) - 1)
        for i, part in enumerate(self.parts):
            rows = index == i
            q[rows], v[rows], a[rows] = part.sample(times[rows] - self._starts[i])
        return q, v, a

    def breakpoints(self) -> np.ndarray:
        """Return the times at which the jerk may be discontinuous [s]."""
        shifted = zip(self.parts, self._starts, strict=False)
        return np.concatenate([part.breakpoints() + start for part, start in shifted])

    def get_state(self) -> dict[str, Any]:
        """Return the trajectory as plain data."""
        return {"kind": "sequence", "parts": [part.get_state() for part in self.parts]}


class BlendedTrajectory(SequenceTrajectory):
    """Trajectories one after the other, each starting in the state of motion of the previous one.

    A part may be left before its end.

    Args:
        parts: The trajectories; the last one ends at rest.
        starts: When each begins [s].
    """

    def __init__(self, parts: Sequence[Trajectory], starts: Sequence[float]) -> None:
        super().__init__(parts)
        self._starts[:-1] = starts
        self.duration = self._starts[-1] = starts[-1] + parts[-1].duration

    def get_state(self) -> dict[str, Any]:
        """Return the trajectory as plain data."""
        state = super().get_state()
        return {**state, "kind": "blended", "starts": self._starts[:-1].tolist()}


class TailTrajectory:
    """The rest of a trajectory from a start time on [s]."""

    def __init__(self, trajectory: Trajectory, start: float) -> None:
        self.trajectory, self.start = trajectory, start
        self.duration = max(0.0, trajectory.duration - start)
        self.end = trajectory.end

    def sample(self, times: np.ndarray) -> Samples:
        """Return q, v and a at the given times [s]."""
        return self.trajectory.sample(times + self.start)

    def breakpoints(self) -> np.ndarray:
        """Return the times at which the jerk may be discontinuous [s]."""
        times = self.trajectory.breakpoints() - self.start
        return times[times > 0.0]

    def get_state(self) -> dict[str, Any]:
        """Return the trajectory as plain data."""
        return {"kind": "tail", "trajectory": self.trajectory.get_state(), "start": self.start}


class TimeScaledTrajectory:
    """A nominal trajectory whose own time s is a function of time, the time scaling s(t).

    The geometric path stays the same. The path velocity s_dot is the speed scale.

    Attributes:
        nominal: The trajectory at speed scale 1.
        time_scaling: Time s of the nominal trajectory over time; never decreasing.
        duration: Time until the nominal trajectory has ended or s_dot stays 0 [s].
        end: Configuration then [rad].  # (nq,)
    """

    def __init__(self, nominal: Trajectory, time_scaling: MotionProfile) -> None:
        self.nominal, self.time_scaling = nominal, time_scaling
        self.duration = _time_of(time_scaling, nominal.duration)
        self.end = nominal.end
        if not self.complete:
            self.end = nominal.sample(np.array([time_scaling.end]))[0][0]

    @property
    def complete(self) -> bool:
        """Whether it reaches the end of the nominal trajectory."""
        return self.time_scaling.at(self.duration)[0] >= self.nominal.duration - 1e-12

    def sample(self, times: np.ndarray) -> Samples:
        """Return q, v and a at the given times [s]."""

        def nominal(s: np.ndarray) -> Samples:
            return self.nominal.sample(np.minimum(s, self.nominal.duration))

        q, v, a = self.time_scaling.sample_along(nominal, times)
        ended = times >= self.duration
        q[ended], v[ended], a[ended] = self.end, 0.0, 0.0
        return q, v, a

    def breakpoints(self) -> np.ndarray:
        """Return the times at which the jerk may be discontinuous [s]."""
        times = np.linspace(0.0, self.duration, 200)
        s = self.time_scaling.sample(times)[0]
        nominal = self.nominal.breakpoints()
        nominal = nominal[(nominal >= s[0]) & (nominal <= s[-1])]
        return np.concatenate([self.time_scaling.breakpoints(), np.interp(nominal, s, times)])

    def get_state(self) -> dict[str, Any]:
        """Return the trajectory as plain data."""
        return {
            "kind": "time-scaled",
            "nominal": self.nominal.get_state(),
            "time_scaling": self.time_scaling.get_state(),
        }


def time_scaling_state(trajectory: Trajectory, t: float) -> tuple[Trajectory, ScalarState]:
    """Return the nominal trajectory and (s, s_dot, s_ddot) at a time [s]."""
    if isinstance(trajectory, TimeScaledTrajectory):
        return trajectory.nominal, trajectory.time_scaling.at(t)
    return trajectory, (t, 1.0, 0.0)


def trajectory_from_state(state: dict[str, Any]) -> Trajectory:
    """Restore a trajectory from plain data.

    Raises:
        MotionError: When the kind of trajectory is unknown, as in snapshots of older versions.
    """
    match state:
        case {"kind": "joints", "profiles": profiles}:
            return JointTrajectory([MotionProfile.from_state(profile) for profile in profiles])
        case {"kind": "path", "path": path, "profile": profile}:
            if limits := state.get("limits"):  # of all coordinates, from an older version
                path = {**path, "limits": [row[path.get("nq", 0) :] for row in limits]}
            return PathTrajectory(path_from_state(path), MotionProfile.from_state(profile))
        case {"kind": "sequence", "parts": parts}:
            return SequenceTrajectory([trajectory_from_state(part) for part in parts])
        case {"kind": "blended", "parts": parts, "starts": starts}:
            return BlendedTrajectory([trajectory_from_state(part) for part in parts], starts)
        case {"kind": "tail", "trajectory": trajectory, "start": start}:
            return TailTrajectory(trajectory_from_state(trajectory), start)
        case {"kind": "time-scaled", "nominal": nominal, "time_scaling": time_scaling}:
            return TimeScaledTrajectory(
                trajectory_from_state(nominal), MotionProfile.from_state(time_scaling)
            )
    raise MotionError(
        f"cannot restore a trajectory of the kind {state.get('kind')!r}: "
        "the snapshot was written by another version of bt-manip",
        reason="target",
    )


def _time_of(profile: MotionProfile, position: float) -> float:
    """Return when a non-decreasing profile reaches a position or ends [s], by bisection."""
    last = profile.duration
    if profile.end <= position:
        return last
    first = 0.0
    for _ in range(60):  # halvings: down to rounding of any duration below MAX_DURATION
        middle = 0.5 * (first + last)
        if profile.at(middle)[0] < position:
            first = middle
        else:
            last = middle
    return last
