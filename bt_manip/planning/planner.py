"""The interface of planners: problem, result and protocol."""

from typing import NamedTuple, Protocol

import numpy as np

from bt_manip.robots import MotionLimits

from .joint_segments import IsFree


class PlanningProblem(NamedTuple):
    """A path planning problem in joint space.

    Attributes:
        start: Start configuration, collision-free [rad].  # (nq,)
        goals: Goal configurations, each collision-free; one is to be reached [rad].  # (n, nq)
        is_free: Tells whether a configuration is collision-free.
        limits: Joint limits.
        rng: The only random generator to use: the same problem gives the same result.
    """

    start: np.ndarray
    goals: np.ndarray
    is_free: IsFree
    limits: MotionLimits
    rng: np.random.Generator

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return lower and upper bounds of the configurations to sample [rad].

        Joints with a range of more than one turn stay within half a turn of start and goals.
        """  # (nq,), (nq,)
        known = np.vstack([self.start, self.goals])
        lower, upper = self.limits.lower, self.limits.upper
        multi_turn = upper - lower > 2.0 * np.pi
        return (
            np.where(multi_turn, np.maximum(lower, known.min(axis=0) - np.pi), lower),
            np.where(multi_turn, np.minimum(upper, known.max(axis=0) + np.pi), upper),
        )


class PlanningResult(NamedTuple):
    """The result of planning.

    Attributes:
        path: Waypoints from the start to one of the goals, connected by straight segments; empty
            when none was found [rad].  # (n, nq)
        samples: Number of configurations that were drawn.
        reason: Why there is no path; empty when there is one.
    """

    path: np.ndarray
    samples: int
    reason: str = ""


class Planner(Protocol):
    """Finds collision-free paths, bounded by a number of samples and never by time."""

    def plan(self, problem: PlanningProblem) -> PlanningResult:
        """Search for a path from the start to one of the goals."""
