"""Two trees that grow towards each other."""

import numpy as np

from .edges import Free, line
from .planner import PlanningProblem, PlanningResult

STEP = 0.04  # [rad] between the configurations that are looked at
REACH = 0.6  # [rad] that a tree grows at the most towards a sample
SAMPLES = 6000
BESIDE = 0.5  # of the samples are drawn beside what a tree has reached
SPREAD = 1.5  # [rad] standard deviation of a joint there, at the most


class RRTConnect:
    """Plan by RRT-Connect.

    J. Kuffner and S. LaValle, "RRT-Connect: An Efficient Approach to Single-Query Path Planning",
    ICRA 2000: one tree grows from the start and one from the goals. By turns one takes a step
    towards a sample, and the other one goes as far towards the new node as is free.

    Some samples are drawn from everywhere; they draw a tree into the open. The others are drawn
    beside a configuration that it has reached, and cut off at the limits: they lead it out of
    narrow places, along limits too, where hardly any sample from everywhere points.
    """

    def __init__(self, *, samples: int = SAMPLES, step: float = STEP, reach: float = REACH) -> None:
        """Set the bounds of the search.

        Args:
            samples: How many configurations are drawn at the most.
            step: Between the configurations that are looked at [rad].
            reach: How far a tree grows towards a sample [rad].
        """
        self.samples, self.step, self.reach = samples, step, reach

    def plan(self, problem: PlanningProblem) -> PlanningResult:
        """Look for a way from the start to one of the goals."""
        lower, upper = problem.bounds()
        room = 2 * self.samples + len(problem.goals) + 1
        start_tree = _Tree(problem.start[np.newaxis], room)
        goal_tree = _Tree(problem.goals, room)
        grown, other = start_tree, goal_tree
        for count in range(self.samples):
            sample = grown.sample(lower, upper, problem.rng)
            new = self._extend(grown, sample, problem.is_free, reach=self.reach)
            if new is not None:
                met = self._extend(other, grown.nodes[new], problem.is_free, reach=np.inf)
                if met is not None and np.array_equal(other.nodes[met], grown.nodes[new]):
                    ends = (new, met) if grown is start_tree else (met, new)
                    before, after = (
                        start_tree.path_to(ends[0]),
                        goal_tree.path_to(ends[1]),
                    )
                    return PlanningResult(np.array(before[::-1] + after[1:]), count + 1)
            # The smaller tree is grown next: in the narrower place.
            grown, other = (other, grown) if other.count < grown.count else (grown, other)
        return PlanningResult(
            np.empty((0, len(problem.start))),
            self.samples,
            f"no way around was found with {self.samples} samples",
        )

    def _extend(self, tree: "_Tree", target: np.ndarray, free: Free, reach: float) -> int | None:
        """Grow the nearest node towards a target as far as is free; None where it is not at all."""
        nearest = tree.nearest(target)
        start = tree.nodes[nearest]
        way = target - start
        length = float(np.abs(way).max())
        if length == 0.0:
            return nearest
        end = target if length <= reach else start + way * (reach / length)
        reached = None
        steps = line(start, end, self.step)
        steps[-1] = end  # exactly
        for q in steps:
            if not free(q):
                break
            reached = q
        return None if reached is None else tree.add(reached, nearest)


class _Tree:
    """Configurations, each with the one that it was reached from."""

    def __init__(self, roots: np.ndarray, room: int) -> None:
        self.nodes = np.empty((room + len(roots), roots.shape[1]))
        self.nodes[: len(roots)] = roots
        self.parents = [-1] * len(roots)
        self.count = len(roots)

    def sample(self, lower: np.ndarray, upper: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Draw a configuration to grow towards, between bounds."""
        if rng.uniform() >= BESIDE:
            return rng.uniform(lower, upper)
        reached = self.nodes[rng.integers(self.count)]
        spread = SPREAD * rng.uniform()
        return np.clip(rng.normal(reached, spread), lower, upper)

    def nearest(self, q: np.ndarray) -> int:
        offset = self.nodes[: self.count] - q
        return int(np.einsum("ij,ij->i", offset, offset).argmin())

    def add(self, q: np.ndarray, parent: int) -> int:
        self.nodes[self.count] = q
        self.parents.append(parent)
        self.count += 1
        return self.count - 1

    def path_to(self, node: int) -> list[np.ndarray]:
        """Give the configurations from a node back to its root."""
        way = []
        while node >= 0:
            way.append(self.nodes[node].copy())
            node = self.parents[node]
        return way
