"""What a planner is asked, and what it answers."""

from typing import NamedTuple, Protocol

import numpy as np

from bt_manip.robots import JointLimits

from .edges import Free


class PlanningProblem(NamedTuple):
    """A way in joint space that is looked for.

    Attributes:
        start: Where it begins; free.  # (nq,)
        goals: Where it may end; each is free.  # (n, nq)
        is_free: Tells of a configuration whether the arm may be there.
        limits: Of the joints.
        rng: The only source of chance: the same problem and generator give the same answer.
    """

    start: np.ndarray
    goals: np.ndarray
    is_free: Free
    limits: JointLimits
    rng: np.random.Generator

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Give the box that is searched.

        Joints that can go around more than once go at the most half a turn beyond start and goals.
        """  # (nq,), (nq,)
        known = np.vstack([self.start, self.goals])
        lower, upper = self.limits.lower, self.limits.upper
        around = upper - lower > 2.0 * np.pi
        return (
            np.where(around, np.maximum(lower, known.min(axis=0) - np.pi), lower),
            np.where(around, np.minimum(upper, known.max(axis=0) + np.pi), upper),
        )


class PlanningResult(NamedTuple):
    """What planning ends with.

    Attributes:
        path: Waypoints from the start to one of the goals, with straight lines between them; empty
            when none was found.  # (n, nq)
        samples: How many configurations were drawn.
        reason: Why there is no path; empty when there is one.
    """

    path: np.ndarray
    samples: int
    reason: str = ""


class Planner(Protocol):
    """Finds ways around what is in the way, bounded by a count of samples and never by time."""

    def plan(self, problem: PlanningProblem) -> PlanningResult:
        """Look for a way from the start to one of the goals."""
