"""The collision-free configurations of one motion."""

from collections.abc import Sequence

import numpy as np

from bt_manip.robots import check_number

from .collision_world import PADDING, CollisionPair, CollisionWorld

CLEARANCE = 4e-3  # [m] from other bodies, if start and end allow it
SELF_CLEARANCE = 1e-3  # [m] between links of the arm, whose relative position is certain
DISTANCE_TOLERANCE = 1e-4  # [m] tolerance of distances at start and end
ESCAPE_RANGE = 0.05  # [rad] around the start within which initial contacts must end
PATH_STEP = 2e-3  # [rad] between checked configurations of a final path


class FreeSpace:
    """The collision-free configurations for one motion from a start to one of several ends.

    The arm keeps a clearance, or for bodies that are nearer at the start or the end, the distance
    at these configurations. Penetration at the start must not increase, and has to end within
    `ESCAPE_RANGE`.

    Args:
        world: The collision world; it is refreshed.
        start: Configuration at the start [rad].  # (nq,)
        ends: Possible final configurations [rad].  # (nq,) each
        clearance: Distance to keep from other bodies [m], at most `PADDING`.

    Raises:
        MotionError: If the clearance is larger than `PADDING`.

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
        """Return whether a configuration is collision-free."""
        escaping = self._in_contact and np.abs(q - self.start).max() < ESCAPE_RANGE
        return self._keeps(q, self._escape_clearance if escaping else self.clearance)

    def path_is_free(self, path: np.ndarray) -> bool:
        """Return whether all configurations of a path are collision-free."""  # (n, nq)
        return self.first_blocked(path) is None

    def first_blocked(self, path: np.ndarray) -> int | None:
        """Return the index of the first configuration of a path in collision, or None."""
        unknown = np.flatnonzero(~self.world.known_free(path, self.clearance))
        return next((int(i) for i in unknown if not self.is_free(path[i])), None)

    def nearest_pair(self, q: np.ndarray) -> CollisionPair | None:
        """Return the nearest pair of bodies at a configuration; None beyond the clearance."""
        return next(iter(self.world.collisions(q, PADDING)), None)

    def _relax(self, q: np.ndarray, clearance: np.ndarray, least: float) -> bool:
        """Reduce the clearance to the distances at a configuration; return whether any is negative.

        Args:
            q: Configuration [rad].  # (nq,)
            clearance: Required distances, changed in place [m].  # (ngeom, ngeom)
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
