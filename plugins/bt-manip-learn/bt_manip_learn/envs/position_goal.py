"""Goals as positions of objects, for learning with relabelled goals."""

from typing import Any

import numpy as np

from bt_manip.cell import extent
from bt_manip.exceptions import BtManipError
from bt_manip_learn.agents import Episodes

TOLERANCE = 0.05
"""Largest difference of a position from one that was relabelled as a goal, along each axis [m]."""


class PositionGoal:
    """Present and desired positions of the objects of a goal, each with a flag.

    Each condition of the goal names an object and, by its ``destination``, the object in or on
    which it belongs. The flag is 1 where the condition holds, in the present goal, and 1 in the
    desired one; so the desired goal is reached if and only if the tree's goal holds. A goal whose
    flag is 0, a relabelled one, is reached at positions within `TOLERANCE`.

    Args:
        episodes: The episodes, of which one has started.

    Raises:
        BtManipError: If a condition of the goal does not define a position.
    """

    def __init__(self, episodes: Episodes) -> None:
        self._episodes = episodes
        self._pairs: list[tuple[str, str]] = []
        for one in episodes.run.tree.goal:
            port = getattr(one, "destination", "")
            if not port:
                raise BtManipError(
                    f"the goal of the tree is not a position: '{one.registration}' does not "
                    "say where an object shall be; make the environment without 'goal_conditioned'"
                )
            name, destination = (str(getattr(one, key)) for key in ("object", port))
            self._pairs.append((name, destination))

    def achieved(self) -> np.ndarray:
        """Return the positions of the objects [m], 0 for removed ones, and the flags."""  # (4n,)
        cell, found = self._episodes.station.cell, []
        reasons = self._episodes.run.goal.reasons()
        for (name, _), reason in zip(self._pairs, reasons, strict=True):
            here = cell.pose(name).translation if name in cell.entities else np.zeros(3)
            found += [*here, not reason]
        return np.array(found, dtype=np.float32)

    def desired(self) -> np.ndarray:
        """Return the middles of the destinations [m], and flags of 1."""  # (4n,)
        cell = self._episodes.station.cell
        middles = [np.mean(extent(cell, name), axis=0) for _, name in self._pairs]
        return np.array([[*middle, 1.0] for middle in middles], dtype=np.float32).ravel()

    def compute_reward(self, achieved_goal: Any, desired_goal: Any, info: Any) -> Any:
        """Return 0 where all parts of the desired goal are reached, otherwise -1.

        Args:
            achieved_goal: Positions of the objects [m] and flags.  # (..., 4n)
            desired_goal: Desired positions [m] and flags.  # (..., 4n)
            info: Unused.
        """  # (...)
        achieved, desired = (
            np.asarray(one, dtype=float).reshape(*np.shape(one)[:-1], -1, 4)
            for one in (achieved_goal, desired_goal)
        )
        near = (np.abs(achieved - desired)[..., :3] <= TOLERANCE).all(axis=-1)
        reached = np.where(desired[..., 3] > 0.5, achieved[..., 3] > 0.5, near).all(axis=-1)
        return np.where(reached, 0.0, -1.0)[()]
