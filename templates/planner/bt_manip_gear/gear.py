"""The planner."""

import numpy as np
from bt_manip.planning import PlanningResult

STEP = 0.02  # [rad] between checked configurations


class Gear:
    """Plan via one random configuration with free segments to start and goal."""

    def __init__(self, samples=2000):
        """Set the number of samples; searches are not bounded by time."""
        self.samples = samples

    def plan(self, problem):
        """Search for a path from the start to one of the goals."""
        lower, upper = problem.bounds()
        for count in range(self.samples):
            via = problem.rng.uniform(lower, upper)
            if segment_is_free(problem.start, via, problem.is_free):
                for goal in problem.goals:
                    if segment_is_free(goal, via, problem.is_free):
                        return PlanningResult(np.array([problem.start, via, goal]), count + 1)
        nothing = np.empty((0, len(problem.start)))
        return PlanningResult(nothing, self.samples, f"no path via {self.samples} configurations")


def segment_is_free(start, end, is_free):
    """Return whether a straight segment, without its start, is collision-free."""
    n = int(np.ceil(np.abs(end - start).max() / STEP)) + 1
    return all(is_free(start + (end - start) * i / n) for i in range(n, 0, -1))
