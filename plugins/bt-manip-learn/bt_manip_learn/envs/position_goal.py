"""Goals as positions of objects, for learning with relabelled goals."""

from typing import Any

import numpy as np

from bt_manip.cell import Cell, extent
from bt_manip.exceptions import BtManipError
from bt_manip_learn.agents import Episodes


class PositionGoal:
    """Present and desired positions of the objects of a goal.

    Each condition of the goal names an object and, by its ``destination``, the object in or on
    which it belongs. A position is reached if, along each world axis, it differs from the middle of
    the destination by at most half the destination's size, plus half the object's size in height.

    Args:
        episodes: The episodes, of which one has started.

    Raises:
        BtManipError: If a condition of the goal does not define a position.
    """

    def __init__(self, episodes: Episodes) -> None:
        cell = episodes.station.cell
        self._pairs: list[tuple[str, str]] = []
        tolerances = []
        for one in episodes.run.tree.goal:
            port = getattr(one, "destination", "")
            if not port:
                raise BtManipError(
                    f"the goal of the tree is not a position: '{one.registration}' does not "
                    "say where an object shall be; make the environment without 'goal_conditioned'"
                )
            name, destination = (str(getattr(one, key)) for key in ("object", port))
            self._pairs.append((name, destination))
            half = 0.5 * np.subtract(*extent(cell, destination)[::-1])
            half[2] += 0.5 * np.subtract(*extent(cell, name)[::-1])[2]
            tolerances.append(half)
        self._tolerance = np.array(tolerances)  # (n, 3)
        self.size = self._tolerance.size

    def achieved(self, cell: Cell) -> np.ndarray:
        """Return the positions of the objects, zeros for removed ones [m]."""  # (3n,)
        names = [name for name, _ in self._pairs]
        found = [cell.pose(n).translation if n in cell.entities else np.zeros(3) for n in names]
        return np.concatenate(found).astype(np.float32)

    def desired(self, cell: Cell) -> np.ndarray:
        """Return the middles of the destinations [m]."""  # (3n,)
        middles = [np.mean(extent(cell, name), axis=0) for _, name in self._pairs]
        return np.concatenate(middles).astype(np.float32)

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: Any) -> Any:
        """Return 0 where all objects are at their destinations, otherwise -1.

        Args:
            achieved_goal: Positions of the objects [m].  # (..., 3n)
            desired_goal: Positions of their destinations [m].  # (..., 3n)
            info: Unused.
        """  # (...)
        differences = np.abs(np.subtract(achieved_goal, desired_goal, dtype=float))
        reached = (differences <= self._tolerance.ravel()).all(axis=-1)
        return np.where(reached, 0.0, -1.0)[()]
