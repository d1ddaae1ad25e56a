"""A lazy probabilistic roadmap: edges are checked only when a shortest path uses them."""

import heapq
from collections.abc import Iterable, Sequence

import numpy as np

from bt_manip.planning import PlanningProblem, PlanningResult, edge_is_free

STEP = 0.04  # [rad] between checked configurations of an edge

Edges = dict[tuple[int, int], bool]  # whether the checked edges are free


class LazyRoadmap:
    """Lazy probabilistic roadmap planner.

    R. Bohlin and L. Kavraki, "Path planning using lazy PRM", ICRA 2000. The roadmap grows in
    batches until there is a path or the maximum number of samples is reached.

    Args:
        samples: Maximum number of samples.
        batch: Number of samples between two searches for a path.
        neighbours: Number of nearest neighbours to which each node is connected.
    """

    def __init__(self, samples: int = 3000, batch: int = 150, neighbours: int = 12):
        self.samples, self.batch, self.neighbours = samples, batch, neighbours

    def plan(self, problem: PlanningProblem) -> PlanningResult:
        """Return the shortest path from the start to one of the goals."""
        lower, upper = problem.bounds()
        nodes = np.vstack([problem.start, problem.goals])  # the start is 0, the goals follow
        goals = range(1, len(nodes))
        known: Edges = {}
        drawn = 0
        while True:
            path = self._shortest_free(nodes, goals, known, problem)
            if path:
                return PlanningResult(nodes[path], drawn)
            if drawn >= self.samples:
                reason = f"no path found with {drawn} samples"
                return PlanningResult(np.empty((0, len(problem.start))), drawn, reason)
            count = min(self.batch, self.samples - drawn)
            drawn += count
            candidates = problem.rng.uniform(lower, upper, (count, len(lower)))
            free = [q for q in candidates if problem.is_free(q)]
            nodes = np.vstack([nodes, *free]) if free else nodes

    def _shortest_free(
        self, nodes: np.ndarray, goals: range, known: Edges, problem: PlanningProblem
    ) -> list[int]:
        """Return the nodes of the shortest free path; empty without one."""
        near = self._near(nodes)
        while True:
            path = shortest(nodes, near, goals, known)
            for a, b in zip(path, path[1:], strict=False):
                edge = (min(a, b), max(a, b))
                if edge not in known:
                    known[edge] = edge_is_free(
                        nodes[edge[0]], nodes[edge[1]], problem.is_free, STEP
                    )
                if not known[edge]:
                    break
            else:
                return path

    def _near(self, nodes: np.ndarray) -> list[set[int]]:
        """Return the symmetric neighbour relation of the nodes."""
        near: list[set[int]] = [set() for _ in nodes]
        for i, node in enumerate(nodes):
            order = np.argsort(np.square(nodes - node).sum(axis=1), kind="stable")
            for j in order[1 : self.neighbours + 1]:
                near[i].add(int(j))
                near[int(j)].add(i)
        return near


def shortest(
    nodes: np.ndarray, near: Sequence[set[int]], goals: Iterable[int], known: Edges
) -> list[int]:
    """Return the shortest path from node 0 to a goal that avoids blocked edges (Dijkstra)."""
    ends = set(goals)
    best = {0: 0.0}
    before: dict[int, int] = {}
    queue = [(0.0, 0)]
    while queue:
        length, i = heapq.heappop(queue)
        if i in ends:
            path = [i]
            while path[-1]:
                path.append(before[path[-1]])
            return path[::-1]
        if length > best[i]:
            continue
        for j in sorted(near[i]):
            if not known.get((min(i, j), max(i, j)), True):
                continue
            total = length + float(np.linalg.norm(nodes[j] - nodes[i]))
            if total < best.get(j, np.inf):
                best[j], before[j] = total, i
                heapq.heappush(queue, (total, j))
    return []
