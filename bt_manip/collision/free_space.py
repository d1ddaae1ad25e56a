"""Where the arm may be during one motion."""

from collections.abc import Sequence

import numpy as np

from .collision_world import PADDING, CollisionPair, CollisionWorld

CLEARANCE = 4e-3  # [m] from everything else, where start and end allow that
OWN_CLEARANCE = 1e-3  # [m] between links, which a controller moves together
SLACK = 1e-4  # [m] nearer than at the start or at the end is no matter
LEAVING = 0.05  # [rad] within which what touches at the start has to be left
PATH_STEP = 2e-3  # [rad] between the configurations that are looked at on a final path


class FreeSpace:
    """Tells of configurations whether they are free, for one motion from a start to an end.

    The arm keeps a clearance, except from what it is nearer to at the start or at the end: from
    that it keeps what it has there. What it touches at the start it may back out of: it may not get
    deeper into it, and has to be free of it within `LEAVING`.
    """

    def __init__(
        self,
        world: CollisionWorld,
        start: np.ndarray,
        ends: Sequence[np.ndarray] = (),
        *,
        clearance: float = CLEARANCE,
    ) -> None:
        """Look at start and end, with everything else where it is now.

        Args:
            world: What there is; it is refreshed.
            start: Where the motion starts.  # (nq,)
            ends: Further configurations that it is known to pass.  # (nq,) each
            clearance: Distance from everything else [m].
        """
        world.refresh()
        self.world, self.start = world, np.array(start)
        clearance = min(clearance, PADDING)
        asked = np.where(world.own, min(OWN_CLEARANCE, clearance), clearance)
        self._needed = np.where(world.counts, asked, -np.inf)  # (ngeom, ngeom)
        for q in ends:
            self._relax(q, self._needed, 0.0)
        leaving = self._needed.copy()
        self._touching = self._relax(start, leaving, -np.inf)
        self._relax(start, self._needed, 0.0)
        self._leaving = leaving

    def _relax(self, q: np.ndarray, needed: np.ndarray, least: float) -> bool:
        """Ask no more of what is near than there is; tell whether anything touches."""
        if not self.world.look(q):
            return False
        first, second, distance = self.world.seen
        counts = self.world.counts[first, second]
        lowered = np.maximum(distance - SLACK, least)
        np.minimum.at(needed, (first[counts], second[counts]), lowered[counts])
        np.minimum.at(needed, (second[counts], first[counts]), lowered[counts])
        return bool((distance[counts] < 0.0).any())

    def is_free(self, q: np.ndarray) -> bool:
        """Tell whether the arm may be at a configuration."""
        leaving = self._touching and np.abs(q - self.start).max() < LEAVING
        return self._keeps(q, self._leaving if leaving else self._needed)

    def keeps_distance(self, q: np.ndarray) -> bool:
        """Tell whether a configuration is free, whatever it touches at the start."""
        return self._keeps(q, self._needed)

    def _keeps(self, q: np.ndarray, needed: np.ndarray) -> bool:
        if not self.world.look(q):
            return True
        first, second, distance = self.world.seen
        return not (distance < needed[first, second]).any()

    def proven(self, path: np.ndarray) -> np.ndarray:
        """Tell which of many configurations keep their distance, with few looks.

        Args:
            path: Configurations [rad].  # (n, nq)

        Returns:
            Where this is False, nothing is known.  # (n,)
        """
        return self.world.proven(path, self._needed)

    def path_is_free(self, path: np.ndarray) -> bool:
        """Tell whether all of many configurations are free."""  # (n, nq)
        return self.first_blocked(path) is None

    def first_blocked(self, path: np.ndarray) -> int | None:
        """Give the index of the first configuration that is not free."""
        unknown = np.flatnonzero(~self.proven(path)).tolist()
        return next((i for i in unknown if not self.is_free(path[i])), None)

    def nearest_pair(self, q: np.ndarray) -> CollisionPair | None:
        """Name what is nearest to the arm at a configuration that is not free."""
        near = self.world.collisions(q, PADDING)
        return near[0] if near else None
