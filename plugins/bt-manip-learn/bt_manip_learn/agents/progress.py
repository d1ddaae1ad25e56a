"""Progress of an episode towards its goal, and loss of objects of the goal."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bt_manip.bt import Node, texts_of
from bt_manip.cell import CellError

from .episodes import Episodes

NEAR = 0.2
"""Distance at which the closeness has fallen to a quarter [m]: 1 - tanh(1) = 0.24."""

FALL = 0.1
"""Distance below the robots and the objects of the goal at which an object is lost [m]."""

WEIGHTS = (0.2, 0.2, 0.4)
"""Weights of reaching, holding and bringing an object; the remainder is for the goal."""


def goal_progress(episodes: Episodes) -> float:
    """Return the progress towards the goal of the tree, from 0 to 1, from the physics.

    It is the mean over the conditions of the goal. A condition that holds counts 1; otherwise,

    - a condition with a method ``progress`` counts 0.9 times its value in [0, 1];
    - a condition that names an object, and perhaps a destination, counts
      ``0.2 max(near, there) + 0.2 max(held, there) + 0.4 there``. ``near`` is
      ``1 - tanh(d / 0.2 m)`` of the distance from the nearest tool to the object, ``there`` that of
      the distance from the object to its destination, and ``held`` is 1 if a gripper holds it;
    - other conditions, and conditions on removed objects, count 0.
    """
    reasons = episodes.run.goal.reasons()
    conditions = zip(episodes.run.tree.goal, reasons, strict=True)
    parts = [_progress(one, episodes) if reason else 1.0 for one, reason in conditions]
    return sum(parts) / len(parts) if parts else 0.0


def _progress(condition: Node, episodes: Episodes) -> float:
    """Return the progress towards a condition that does not hold."""
    if hasattr(condition, "progress"):
        try:
            return 0.9 * float(np.clip(condition.progress(), 0.0, 1.0))
        except CellError:
            return 0.0
    cell, robots = episodes.station.cell, episodes.station.robots.values()
    names = texts_of(condition)
    if not names or names[0] not in cell.entities:
        return 0.0
    position = cell.pose(names[0]).translation
    tools = [one.robot.tool_pose.translation for one in robots]
    near = max(_closeness(position, tool) for tool in tools)
    held = any(one.gripper is not None and names[0] in one.gripper.held for one in robots)
    others = [cell.pose(name).translation for name in names[1:] if name in cell.objects]
    there = max((_closeness(position, other) for other in others), default=0.0)
    return float(np.dot(WEIGHTS, [max(near, there), max(held, there), there]))


def _closeness(a: np.ndarray, b: np.ndarray) -> float:
    d = a - b
    return 1.0 - float(np.tanh(math.sqrt(d.dot(d)) / NEAR))  # the bits of NumPy's norm, faster


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
            distances = [np.linalg.norm(position - shoulder) for shoulder in self._shoulders]
            if all(d > reach for d, reach in zip(distances, self._reach, strict=True)):
                return f"'{name}' is out of reach"
        return ""

    def _is_met(self, name: str) -> bool:
        """Return whether the goal names an object and all its conditions on it hold."""
        pairs = zip(self._run.tree.goal, self._run.goal.reasons(), strict=True)
        reasons = [reason for condition, reason in pairs if name in texts_of(condition)]
        return bool(reasons) and not any(reasons)
