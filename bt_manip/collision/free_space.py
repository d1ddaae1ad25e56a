"""The collision-free configurations of one motion."""

from collections.abc import Sequence

import numpy as np

from bt_manip.robots import check_number

from .collision_world import PADDING, CollisionPair, CollisionWorld

CLEARANCE = 4e-3  # [m] from everything else, where start and end allow that
SELF_CLEARANCE = 1e-3  # [m] between links of the arm, whose relative position is certain
DISTANCE_TOLERANCE = 1e-4  # [m] by which distances at start and end may be undercut
ESCAPE_RANGE = 0.05  # [rad] around the start within which contacts there must be left
PATH_STEP = 2e-3  # [rad] between the configurations that are checked on a final path


class FreeSpace:
    """Tells whether configurations are collision-free, for one motion from a start to an end.

    The arm keeps a clearance, except from bodies that are nearer at the start or at the end: there
    it keeps the distance of these configurations. From bodies that it touches at the start it may
    escape: penetration must not increase, and has to end within `ESCAPE_RANGE`.

    Attributes:
        clearance: Required distance of each pair of geoms [m].  # (ngeom, ngeom)
    """

    def __init__(
        self,
        world: CollisionWorld,
        start: np.ndarray,
        ends: Sequence[np.ndarray] = (),
        *,
        clearance: float = CLEARANCE,
    ) -> None:
        """Measure the distances at start and ends, with everything else where it is now.

        Args:
            world: The collision world; it is refreshed.
            start: Configuration at the start [rad].  # (nq,)
            ends: Possible final configurations [rad].  # (nq,) each
            clearance: Distance to keep from everything else [m], at most `PADDING`.

        Raises:
            MotionError: When the clearance is larger.
        """
        check_number(clearance, "clearance", "m", at_most=PADDING)
        world.refresh()
        self.world, self.start = world, np.array(start)
        clearances = np.where(world.self_pairs, min(SELF_CLEARANCE, clearance), clearance)
        self.clearance = np.where(world.checked_pairs, clearances, -np.inf)  # (ngeom, ngeom)
        for q in ends:
            self._relax(q, self.clearance, 0.0)
        self._escape_clearance = self.clearance.copy()
        self._in_contact = self._relax(start, self._escape_clearance, -np.inf)
        self._relax(start, self.clearance, 0.0)

    def is_free(self, q: np.ndarray) -> bool:
        """Tell whether a configuration is collision-free."""
        escaping = self._in_contact and np.abs(q - self.start).max() < ESCAPE_RANGE
        return self._keeps(q, self._escape_clearance if escaping else self.clearance)

    def path_is_free(self, path: np.ndarray) -> bool:
        """Tell whether all configurations of a path are collision-free."""  # (n, nq)
        return self.first_blocked(path) is None

    def first_blocked(self, path: np.ndarray) -> int | None:
        """Return the index of the first configuration of a path in collision; None without one."""
        unknown = np.flatnonzero(~self.world.known_free(path, self.clearance))
        return next((int(i) for i in unknown if not self.is_free(path[i])), None)

    def nearest_pair(self, q: np.ndarray) -> CollisionPair | None:
        """Return the nearest pair of bodies at a configuration; None where none is near."""
        return next(iter(self.world.collisions(q, PADDING)), None)

    def _relax(self, q: np.ndarray, clearance: np.ndarray, least: float) -> bool:
        """Reduce the clearance to the distances at a configuration; tell whether any is negative.

        Args:
            q: Configuration [rad].  # (nq,)
            clearance: Required distances, which are changed [m].  # (ngeom, ngeom)
            least: Lower bound of the result [m].
        """
        if not self.world.collide(q):
            return False
        first, second, distance = self.world.contacts
        checked = self.world.checked_pairs[first, second]
        first, second, distance = first[checked], second[checked], distance[checked]
        reduced = np.maximum(distance - DISTANCE_TOLERANCE, least)
        np.minimum.at(clearance, (first, second), reduced)
        np.minimum.at(clearance, (second, first), reduced)
        return bool((distance < 0.0).any())

    def _keeps(self, q: np.ndarray, clearance: np.ndarray) -> bool:
        if not self.world.collide(q):
            return True
        first, second, distance = self.world.contacts
        return not (distance < clearance[first, second]).any()
