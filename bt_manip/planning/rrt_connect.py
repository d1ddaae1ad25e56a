"""RRT-Connect: a bidirectional rapidly-exploring random tree."""

import numpy as np

from .joint_segments import IsFree, discretize_segment
from .planner import PlanningProblem, PlanningResult

CHECKED_STEP = 0.04  # [rad] between the configurations that are checked
RANGE = 0.6  # [rad] longest extension towards a sample
SAMPLES = 6000
LOCAL_SHARE = 0.5  # of the samples are drawn around a node of the tree
LOCAL_DEVIATION = 1.5  # [rad] largest standard deviation of these


class RRTConnect:
    """Plan by RRT-Connect.

    J. Kuffner and S. LaValle, "RRT-Connect: An Efficient Approach to Single-Query Path Planning",
    ICRA 2000: one tree grows from the start and one from the goals. In turns, one is extended
    towards a sample, and the other one is connected to the new node as far as is free.

    Besides uniform samples, which drive exploration, samples are drawn from a normal distribution
    around a random node and clipped to the bounds: they find the way out of narrow passages, also
    along joint limits.

    Args:
        samples: Largest number of samples.
        step: Distance between the configurations that are checked [rad].
    """

    def __init__(self, *, samples: int = SAMPLES, step: float = CHECKED_STEP) -> None:
        self.samples, self.step = samples, step

    def plan(self, problem: PlanningProblem) -> PlanningResult:
        """Search for a path from the start to one of the goals."""
        lower, upper = problem.bounds()
        start_tree = _Tree(problem.start[np.newaxis], self.samples)
        goal_tree = _Tree(problem.goals, self.samples)
        tree, other = start_tree, goal_tree
        for count in range(self.samples):
            sample = tree.sample(lower, upper, problem.rng)
            new = self._extend(tree, sample, problem.is_free, RANGE)
            if new is not None:
                met = self._extend(other, tree.nodes[new], problem.is_free, np.inf)
                if met is not None and np.array_equal(other.nodes[met], tree.nodes[new]):
                    ends = (new, met) if tree is start_tree else (met, new)
                    first, last = start_tree.branch(ends[0]), goal_tree.branch(ends[1])
                    return PlanningResult(np.array(first[::-1] + last[1:]), count + 1)
            # The smaller tree, which is in the narrower place, is extended next.
            tree, other = (other, tree) if other.count < tree.count else (tree, other)
        return PlanningResult(
            np.empty((0, len(problem.start))),
            self.samples,
            f"no path found with {self.samples} samples",
        )

    def _extend(
        self, tree: "_Tree", target: np.ndarray, is_free: IsFree, max_extension: float
    ) -> int | None:
        """Extend the nearest node towards a target as far as is free; None where nothing is."""
        nearest = tree.nearest(target)
        start = tree.nodes[nearest]
        offset = target - start
        length = float(np.abs(offset).max())
        if length == 0.0:
            return nearest
        end = target if length <= max_extension else start + offset * (max_extension / length)
        reached = None
        steps = discretize_segment(start, end, self.step)
        steps[-1] = end  # exactly
        for q in steps:
            if not is_free(q):
                break
            reached = q
        return None if reached is None else tree.add(reached, nearest)


class _Tree:
    """Configurations, each with the index of its parent."""

    def __init__(self, roots: np.ndarray, capacity: int) -> None:
        self.nodes = np.empty((capacity + len(roots), roots.shape[1]))
        self.nodes[: len(roots)] = roots
        self.parents = [-1] * len(roots)
        self.count = len(roots)

    def sample(self, lower: np.ndarray, upper: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        """Draw a configuration between bounds."""
        if rng.uniform() >= LOCAL_SHARE:
            return rng.uniform(lower, upper)
        node = self.nodes[rng.integers(self.count)]
        deviation = LOCAL_DEVIATION * rng.uniform()
        return np.clip(rng.normal(node, deviation), lower, upper)

    def nearest(self, q: np.ndarray) -> int:
        """Return the index of the node nearest to a configuration."""
        offset = self.nodes[: self.count] - q
        return int(np.einsum("ij,ij->i", offset, offset).argmin())

    def add(self, q: np.ndarray, parent: int) -> int:
        """Add a node and return its index."""
        self.nodes[self.count] = q
        self.parents.append(parent)
        self.count += 1
        return self.count - 1

    def branch(self, node: int) -> list[np.ndarray]:
        """Return the configurations from a node back to its root."""
        branch = []
        while node >= 0:
            branch.append(self.nodes[node].copy())
            node = self.parents[node]
        return branch
