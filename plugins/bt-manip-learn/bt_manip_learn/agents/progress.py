"""Progress of an episode towards its goal, and loss of objects of the goal."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from bt_manip.behaviours import Destination
from bt_manip.bt import Node, texts_of
from bt_manip.cell import Cell, CellError, extent
from bt_manip.runner import CommandedRobot

from .episodes import Episodes

FALL = 0.1
"""Distance below the robots and the objects of the goal at which an object is lost [m]."""

NOT_YET = 0.9
"""Largest progress of a condition that does not hold."""

HALF_WAY = 0.2
"""Distance at which the closeness is a half [m]."""

EDGE = 0.02
"""Distance beside or below a place over which an object comes to be over it [m]."""

SUNK = 5e-3
"""Depth below a place at which an object may rest, as on a soft one [m]."""


def goal_progress(episodes: Episodes) -> float:
    """Return the progress towards the goal of the tree, from 0 to 1, from the physics.

    It is the mean over the conditions of the goal: 1 for a condition that holds, otherwise
    `NOT_YET` times its method ``progress``, or if it has a method ``places`` times
    `placing_progress`; with both, 0.4 of the first and 0.6 of the second. A condition without them,
    and one on a removed object, counts 0.
    """
    reasons = episodes.run.goal.reasons()
    conditions = zip(episodes.run.tree.goal, reasons, strict=True)
    parts = [_progress(one, episodes) if reason else 1.0 for one, reason in conditions]
    return sum(parts) / len(parts) if parts else 0.0


def without_progress(goal: Iterable[Node]) -> list[str]:
    """Return the registered names of the conditions without methods ``progress`` and ``places``."""
    found = (one for one in goal if not (hasattr(one, "progress") or hasattr(one, "places")))
    return list(dict.fromkeys(one.registration for one in found))


def _progress(condition: Any, episodes: Episodes) -> float:
    """Return the progress towards a condition that does not hold."""
    parts = []
    try:
        if hasattr(condition, "places"):
            station = episodes.station
            placed = placing_progress(station.cell, station.robots, condition.places())
            parts.append((0.6, placed))
        if hasattr(condition, "progress"):
            parts.append((0.4, float(np.clip(condition.progress(), 0.0, 1.0))))
    except CellError:
        return 0.0
    total = sum(weight for weight, _ in parts) or 1.0
    return NOT_YET * sum(weight * value for weight, value in parts) / total


def placing_progress(
    cell: Cell, robots: Mapping[str, CommandedRobot], places: Mapping[str, Destination | None]
) -> float:
    """Return the progress of bringing objects to their places, from 0 to 1.

    That of an object is ``0.2 reached + 0.2 held + 0.5 there + 0.1 down``: the closeness of the
    nearest tool; whether a gripper holds it; the closeness of the object to its place, along the
    way up and sideways; and, over the place, that to where it rests. Over its place the first two
    count 1, so that to release it there costs nothing. Of several objects it is the mean, in which
    the first two count for one object that is not there yet, the most advanced. Objects that are
    not in the cell or have no place count 0.
    """
    tools = [one.robot.tool_pose.translation for one in robots.values()]
    held = {n for one in robots.values() if one.gripper is not None for n in one.gripper.held}
    total = most = 0.0
    for name, place in places.items():
        if place is None or name not in cell.entities:
            continue
        lower, upper = extent(cell, name)
        middle, size = 0.5 * (lower + upper), upper - lower
        bottom = place.T_wd.actInv(np.array([middle[0], middle[1], lower[2]]))
        width = float(min(size[:2])) if place.walls else 0.0
        placed, over = _placed(bottom.tolist(), place, width)
        away = min(math.dist(tool, middle) for tool in tools)
        holds = name in held
        reached = 1.0 if holds else closeness(away)
        handled = 0.2 * max(reached - over, 0.0) + 0.2 * max(holds - over, 0.0)
        total, most = total + placed, max(most, handled)
    return (total + most) / max(len(places), 1)


def closeness(distance: float) -> float:
    """Return 1 at distance 0, a half at `HALF_WAY`, and ever less beyond [m]."""
    return HALF_WAY / (HALF_WAY + distance)


def _placed(bottom: Sequence[float], place: Destination, width: float) -> tuple[float, float]:
    """Return the largest progress without reaching and holding, and whether it is over its place.

    Args:
        bottom: Middle of the object's bottom, in the frame of the place [m].  # (3,)
        place: The place.
        width: Width of the object [m].
    """
    x, y, z = bottom
    found = []
    for (x_0, y_0, z_0), (x_1, y_1, z_1) in zip(
        place.lower.tolist(), place.upper.tolist(), strict=True
    ):
        half = [max(0.5 * (high - low - width), 0.0) for low, high in ((x_0, x_1), (y_0, y_1))]
        beside = abs(x - 0.5 * (x_0 + x_1)) - half[0], abs(y - 0.5 * (y_0 + y_1)) - half[1]
        aside = math.hypot(max(beside[0], 0.0), max(beside[1], 0.0))
        edge, under = min(aside / EDGE, 1.0), max(z_0 - SUNK - z, 0.0)
        over = (1.0 - edge) * max(1.0 - under / EDGE, 0.0)
        there = closeness(aside + max(edge * (z_1 - z), under, 0.0))
        found.append((0.4 * over + 0.5 * there + 0.1 * over * closeness(abs(z - z_0)), over))
    return max(found)


class LossCheck:
    """Detects the loss of an object of the goal: removed, fallen or out of reach.

    It watches the free objects that the goal names, or all free objects if it names none.

    Args:
        episodes: The episodes, at the start of one.
    """

    def __init__(self, episodes: Episodes) -> None:
        self._cell = cell = episodes.station.cell
        self._run = episodes.run
        robots = episodes.station.robots
        named = [text for one in episodes.run.tree.goal for text in texts_of(one)]
        known = [name for name in dict.fromkeys(named) if name in cell.entities]
        free = [name for name in cell.objects if cell.is_free(name)]
        self._objects = [name for name in free if name in known] or free
        known += self._objects
        self._lowest = min(cell.pose(name).translation[2] for name in [*known, *robots]) - FALL
        models = [one.arm.model for one in robots.values()]
        self._shoulders = [model.model.jointPlacements[1].translation.copy() for model in models]
        self._reach = [float(model.levers.max()) for model in models]

    def get_state(self) -> dict[str, Any]:
        """Return the state stored at the start of the episode, as plain data."""
        return {"objects": self._objects, "lowest": float(self._lowest)}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state of `get_state`."""
        self._objects, self._lowest = state["objects"], state["lowest"]

    def reason(self) -> str:
        """Return the first lost object with the reason; empty if none is lost."""
        for name in self._objects:
            if name not in self._cell.entities:
                if self._is_met(name):
                    continue  # removed on purpose
                return f"'{name}' has left the cell"
            position = self._cell.pose(name).translation
            if position[2] < self._lowest:
                return f"'{name}' has fallen"
            distances = [math.dist(position, shoulder) for shoulder in self._shoulders]
            if all(d > reach for d, reach in zip(distances, self._reach, strict=True)):
                return f"'{name}' is out of reach"
        return ""

    def _is_met(self, name: str) -> bool:
        """Return whether the goal names an object and all its conditions on it hold."""
        pairs = zip(self._run.tree.goal, self._run.goal.reasons(), strict=True)
        reasons = [reason for condition, reason in pairs if name in texts_of(condition)]
        return bool(reasons) and not any(reasons)
