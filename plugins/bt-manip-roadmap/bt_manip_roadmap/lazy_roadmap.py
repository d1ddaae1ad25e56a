"""A lazy probabilistic roadmap: edges are checked only when a shortest path uses them."""

from itertools import pairwise

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
        from scipy.sparse import csgraph, csr_array  # takes a while to import

        edges = self._edges(nodes)
        lengths = np.linalg.norm(nodes[edges[:, 1]] - nodes[edges[:, 0]], axis=1)
        while True:
            usable = np.array([known.get((a, b), True) for a, b in edges.tolist()])
            graph = csr_array((lengths[usable], edges[usable].T), shape=(len(nodes),) * 2)
            distance, before = csgraph.dijkstra(
                graph, directed=False, indices=0, return_predecessors=True
            )
            path = [min(goals, key=distance.__getitem__)]
            if np.isinf(distance[path[0]]):
                return []
            while path[0]:
                path.insert(0, int(before[path[0]]))
            for a, b in pairwise(path):
                edge = (min(a, b), max(a, b))
                if edge not in known:
                    known[edge] = edge_is_free(
                        nodes[edge[0]], nodes[edge[1]], problem.is_free, STEP
                    )
                if not known[edge]:
                    break
            else:
                return path

    def _edges(self, nodes: np.ndarray) -> np.ndarray:
        """Return the pairs of each node and its nearest neighbours, the lower number first."""
        edges = []  # (n, 2)
        for i, node in enumerate(nodes):
            order = np.argsort(np.square(nodes - node).sum(axis=1), kind="stable")
            edges += [sorted((i, j)) for j in order[1 : self.neighbours + 1].tolist()]
        return np.unique(np.reshape(edges, (-1, 2)), axis=0)
