"""A roadmap whose lines are looked at only when a shortest way goes along them."""

import heapq

import numpy as np

from bt_manip.planning import PlanningProblem, PlanningResult, edge_is_free

STEP = 0.04
"""Longest way of a joint between two configurations that are looked at [rad]."""


class LazyRoadmap:
    """Plan by a lazy probabilistic roadmap.

    R. Bohlin and L. Kavraki, "Path planning using lazy PRM", ICRA 2000. The roadmap grows batch by
    batch until a way is found or the samples are used up: the search is bounded by a count.
    """

    def __init__(self, samples: int = 3000, batch: int = 150, neighbours: int = 12):
        """Set the bounds of the search.

        Args:
            samples: How many configurations are drawn at the most.
            batch: How many are drawn before a way is looked for again.
            neighbours: To how many of the nearest each is connected.
        """
        self.samples, self.batch, self.neighbours = samples, batch, neighbours

    def plan(self, problem: PlanningProblem) -> PlanningResult:
        """Look for the shortest way from the start to one of the goals."""
        lower, upper = problem.bounds()
        nodes = np.vstack([problem.start, problem.goals])  # the start is 0, the goals follow
        goals = range(1, len(nodes))
        known: dict[tuple[int, int], bool] = {}  # lines that were looked at
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

    def _shortest_free(self, nodes, goals, known, problem) -> list[int]:
        """Look for shortest ways until one is free; empty where there is none."""
        near = self._near(nodes)
        while True:
            path = shortest(nodes, near, goals, known)
            blocked = False
            for a, b in zip(path, path[1:], strict=False):
                edge = (min(a, b), max(a, b))
                if edge not in known:
                    known[edge] = edge_is_free(
                        nodes[edge[0]], nodes[edge[1]], problem.is_free, STEP
                    )
                if not known[edge]:
                    blocked = True
                    break
            if not blocked:
                return path

    def _near(self, nodes: np.ndarray) -> list[set[int]]:
        """Connect each node with those nearest to it, both ways."""
        near: list[set[int]] = [set() for _ in nodes]
        for i, node in enumerate(nodes):
            order = np.argsort(np.square(nodes - node).sum(axis=1), kind="stable")
            for j in order[1 : self.neighbours + 1]:
                near[i].add(int(j))
                near[int(j)].add(i)
        return near


def shortest(nodes, near, goals, known) -> list[int]:
    """Find the shortest way from node 0 to a goal by Dijkstra, without lines known as blocked."""
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
            there = length + float(np.linalg.norm(nodes[j] - nodes[i]))
            if there < best.get(j, np.inf):
                best[j], before[j] = there, i
                heapq.heappush(queue, (there, j))
    return []
