"""The planner."""

import numpy as np
from bt_manip.planning import PlanningResult

STEP = 0.02
"""Longest way of a joint between two configurations that are looked at [rad]."""


class Gear:
    """Go by way of one configuration, drawn until both lines to it are free."""

    def __init__(self, samples=2000):
        """Bound the search by a count, never by time: the same seed gives the same path."""
        self.samples = samples

    def plan(self, problem):
        """Look for a path from the start to one of the goals."""
        lower, upper = problem.bounds()
        for count in range(self.samples):
            via = problem.rng.uniform(lower, upper)
            if line_is_free(problem.start, via, problem.is_free):
                for goal in problem.goals:
                    if line_is_free(goal, via, problem.is_free):
                        return PlanningResult(np.array([problem.start, via, goal]), count + 1)
        nothing = np.empty((0, len(problem.start)))
        return PlanningResult(nothing, self.samples, f"no path via {self.samples} configurations")


def line_is_free(start, end, free):
    """Look at the configurations on a straight line, its start left out."""
    n = int(np.ceil(np.abs(end - start).max() / STEP)) + 1
    return all(free(start + (end - start) * i / n) for i in range(n, 0, -1))
