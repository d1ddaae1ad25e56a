"""Configurations over time."""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np

from .bounds import Bounds
from .jerk_profile import JerkProfile, check_duration
from .paths import Path, path_from_state

Table = tuple[np.ndarray, np.ndarray, np.ndarray]  # q, v, a: (n, nq) each


class Trajectory(Protocol):
    """Position, velocity and acceleration of all joints over time, at rest from the end on."""

    duration: float  # [s]
    end: np.ndarray  # configuration at the end  (nq,)

    def table(self, times: np.ndarray) -> Table:
        """Give q, v and a at many times; cheap per time."""

    def sample(self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Write q, v and a at a time into arrays."""

    def corners(self) -> np.ndarray:
        """Give the times when the jerk changes; in between the acceleration has no extreme."""

    def get_state(self) -> dict[str, Any]:
        """Give the trajectory as plain data."""


def step_times(duration: float, step: float) -> np.ndarray:
    """Give the times of all steps from 0 until a trajectory has ended.

    Raises:
        MotionError: When it takes too long.
    """
    check_duration(duration)
    return step * np.arange(int(np.ceil(duration / step - 1e-9)) + 2)


class JointTrajectory:
    """Each joint by its own profile; all end at the same time (time-synchronised)."""

    def __init__(self, profiles: Sequence[JerkProfile]) -> None:
        """Join the profiles of all joints."""
        self._profiles = list(profiles)
        self.duration = max(profile.duration for profile in profiles)
        self.end = np.array([profile.end for profile in profiles])

    def table(self, times: np.ndarray) -> Table:
        """Give q, v and a at many times."""
        columns = [profile.table(times) for profile in self._profiles]
        q, v, a = (np.stack(rows, axis=1) for rows in zip(*columns, strict=True))
        return q, v, a

    def sample(self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Write q, v and a at a time into arrays."""
        for i, profile in enumerate(self._profiles):
            q[i], v[i], a[i] = profile.sample(t)

    def corners(self) -> np.ndarray:
        """Give the times when the jerk changes."""
        return np.unique(np.concatenate([profile.corners() for profile in self._profiles]))

    def get_state(self) -> dict[str, Any]:
        """Give the trajectory as plain data."""
        return {"kind": "joints", "profiles": [profile.get_state() for profile in self._profiles]}


class PathTrajectory:
    """A path in joint space, driven by one profile of its parameter.

    It never leaves the path, whatever it does in time.
    """

    def __init__(self, path: Path, profile: JerkProfile, bounds: Bounds) -> None:
        """Drive a path.

        Args:
            path: The curve.
            profile: Its parameter over time.
            bounds: What its coordinates may do.
        """
        self.path, self.profile, self.bounds = path, profile, bounds
        self.duration = profile.duration
        self.end = path.end
        if profile.end != 1.0:
            self.end = path.evaluate(np.array([profile.end]), 0)[0][0, : path.nq]

    def coordinates(self, times: np.ndarray) -> Table:
        """Give all coordinates of the path, with their derivatives, at many times."""
        s, ds, dds = (x[:, np.newaxis] for x in self.profile.table(times))
        x, dx, ddx = self.path.evaluate(s[:, 0])
        return x, dx * ds, ddx * (ds * ds) + dx * dds

    def use(self, step: float = 1e-3) -> tuple[float, float, float]:
        """Give the largest fractions of velocity, acceleration and jerk, behind the joints too."""
        _, v, a = self.coordinates(step_times(self.duration, step))
        return self.bounds.use(v, a, step)

    def table(self, times: np.ndarray) -> Table:
        """Give q, v and a at many times."""
        q, v, a = (x[:, : self.path.nq] for x in self.coordinates(times))
        q[times >= self.duration] = self.end
        return q, v, a

    def sample(self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Write q, v and a at a time into arrays."""
        rows = self.table(np.array([t]))
        q[:], v[:], a[:] = rows[0][0], rows[1][0], rows[2][0]

    def corners(self) -> np.ndarray:
        """Give the times when the jerk changes."""
        return self.profile.corners()

    def get_state(self) -> dict[str, Any]:
        """Give the trajectory as plain data."""
        return {
            "kind": "path",
            "path": self.path.get_state(),
            "profile": self.profile.get_state(),
            "bounds": [bound.tolist() for bound in self.bounds],
        }


class SequenceTrajectory:
    """Trajectories one after the other; each starts at rest where the one before ends."""

    def __init__(self, parts: Sequence[Trajectory]) -> None:
        """Join trajectories."""
        self.parts = list(parts)
        self.starts = np.concatenate([[0.0], np.cumsum([part.duration for part in parts])])
        self.duration = float(self.starts[-1])
        self.end = self.parts[-1].end

    def active(self, t: float) -> tuple[Trajectory, float]:
        """Give the part that a time falls into, and the time since it began."""
        i = min(int(np.searchsorted(self.starts, t, side="right")) - 1, len(self.parts) - 1)
        return self.parts[i], t - float(self.starts[i])

    def table(self, times: np.ndarray) -> Table:
        """Give q, v and a at many times."""
        q, v, a = (np.empty((len(times), len(self.end))) for _ in range(3))
        which = np.searchsorted(self.starts, times, side="right") - 1
        which = np.minimum(which, len(self.parts) - 1)
        for i, part in enumerate(self.parts):
            rows = which == i
            q[rows], v[rows], a[rows] = part.table(times[rows] - self.starts[i])
        return q, v, a

    def sample(self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Write q, v and a at a time into arrays."""
        part, since = self.active(t)
        part.sample(since, q, v, a)

    def corners(self) -> np.ndarray:
        """Give the times when the jerk changes."""
        shifted = zip(self.parts, self.starts, strict=False)
        return np.concatenate([part.corners() + start for part, start in shifted])

    def get_state(self) -> dict[str, Any]:
        """Give the trajectory as plain data."""
        return {"kind": "sequence", "parts": [part.get_state() for part in self.parts]}


class TailTrajectory:
    """What is left of a trajectory from some time on."""

    def __init__(self, whole: Trajectory, since: float) -> None:
        """Leave out what was before a time [s]."""
        self.whole, self.since = whole, since
        self.duration = max(0.0, whole.duration - since)
        self.end = whole.end

    def table(self, times: np.ndarray) -> Table:
        """Give q, v and a at many times."""
        return self.whole.table(times + self.since)

    def sample(self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Write q, v and a at a time into arrays."""
        self.whole.sample(t + self.since, q, v, a)

    def corners(self) -> np.ndarray:
        """Give the times when the jerk changes."""
        left = self.whole.corners() - self.since
        return left[left > 0.0]

    def get_state(self) -> dict[str, Any]:
        """Give the trajectory as plain data."""
        return {"kind": "tail", "whole": self.whole.get_state(), "since": self.since}


def trajectory_from_state(state: dict[str, Any]) -> Trajectory:
    """Make a trajectory from plain data."""
    if state["kind"] == "joints":
        return JointTrajectory([JerkProfile.from_state(p) for p in state["profiles"]])
    if state["kind"] == "paced":
        from .time_scaled_trajectory import (
            TimeScaledTrajectory,  # which is made of trajectories, too
        )

        return TimeScaledTrajectory.from_state(state)
    if state["kind"] == "sequence":
        return SequenceTrajectory([trajectory_from_state(part) for part in state["parts"]])
    if state["kind"] == "tail":
        return TailTrajectory(trajectory_from_state(state["whole"]), state["since"])
    return PathTrajectory(
        path_from_state(state["path"]),
        JerkProfile.from_state(state["profile"]),
        Bounds(*(np.array(bound) for bound in state["bounds"])),
    )
