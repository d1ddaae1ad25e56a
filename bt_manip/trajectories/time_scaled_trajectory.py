"""A trajectory at another pace: slower, faster again, or brought to rest on its own path."""

from typing import Any

import numpy as np

from .jerk_profile import JerkProfile
from .trajectory import Table, Trajectory, trajectory_from_state

_HALVINGS = 60


class TimeScaledTrajectory:
    """Goes through a trajectory by a time of its own, and so never leaves its path.

    Attributes:
        whole: The trajectory.
        clock: Time of the whole over time; its slope is the pace.
        duration: Until the whole has ended, or the pace is nought [s].
        end: Configuration then [rad].  # (nq,)
    """

    def __init__(self, whole: Trajectory, clock: JerkProfile) -> None:
        """Pace a trajectory."""
        self.whole, self.clock = whole, clock
        self.duration = _when(clock, whole.duration)
        self.end = whole.end
        if not self.complete:
            self.end = whole.table(np.array([clock.end]))[0][0]

    @property
    def complete(self) -> bool:
        """Whether it goes to the end of the whole."""
        return self.clock.sample(self.duration)[0] >= self.whole.duration - 1e-12

    def table(self, times: np.ndarray) -> Table:
        """Give q, v and a at many times."""
        now, pace, change = (x[:, np.newaxis] for x in self.clock.table(times))
        q, v, a = self.whole.table(np.minimum(now[:, 0], self.whole.duration))
        q, v, a = q, v * pace, a * (pace * pace) + v * change
        ended = times >= self.duration
        q[ended], v[ended], a[ended] = self.end, 0.0, 0.0
        return q, v, a

    def sample(self, t: float, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> None:
        """Write q, v and a at a time into arrays."""
        rows = self.table(np.array([t]))
        q[:], v[:], a[:] = rows[0][0], rows[1][0], rows[2][0]

    def corners(self) -> np.ndarray:
        """Give the times when the jerk changes."""
        times = np.linspace(0.0, self.duration, 200)
        now = self.clock.table(times)[0]
        inside = self.whole.corners()
        inside = inside[(inside >= now[0]) & (inside <= now[-1])]
        return np.concatenate([self.clock.corners(), np.interp(inside, now, times)])

    def get_state(self) -> dict[str, Any]:
        """Give the trajectory as plain data."""
        return {
            "kind": "paced",
            "whole": self.whole.get_state(),
            "clock": self.clock.get_state(),
        }

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> "TimeScaledTrajectory":
        """Make a trajectory from plain data."""
        whole = trajectory_from_state(state["whole"])
        return cls(whole, JerkProfile.from_state(state["clock"]))


def _when(clock: JerkProfile, reading: float) -> float:
    """Give the time when a clock that never goes back shows something, or stops before [s]."""
    last = clock.duration
    if clock.end <= reading:
        return last
    first = 0.0
    for _ in range(_HALVINGS):
        middle = 0.5 * (first + last)
        if clock.sample(middle)[0] < reading:
            first = middle
        else:
            last = middle
    return last
