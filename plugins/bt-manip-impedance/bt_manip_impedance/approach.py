"""Objects of a kind, and conditions on one that robots approach."""

import math
from collections.abc import Mapping
from typing import Any, TypeVar

import numpy as np

from bt_manip.behaviours import ObjectCondition
from bt_manip.cell import Cell, CellError, ParametricEntity

T = TypeVar("T", bound=ParametricEntity)

NEAR = 0.2
"""Distance of the nearest tool at which the progress of approaching is a quarter [m]."""


def find_of(cell: Cell, name: str, kind: type[T]) -> T:
    """Return an object of a kind.

    Raises:
        CellError: If there is no such object, or it is of another kind.
    """
    found = cell.find(name)
    if not isinstance(found, kind):
        raise CellError(f"'{name}' is not a {kind.category}")
    return found


class ApproachCondition(ObjectCondition):
    """A condition on an object; its progress begins with the approach of a robot."""

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell and the robots."""
        super().setup(**infrastructure)
        self.robots: Mapping[str, Any] = infrastructure.get("robots", {})

    def closeness(self, point: np.ndarray) -> float:
        """Return how close the nearest tool is to a point in the world: 1 there, 0 far away."""
        tools = [one.robot.tool_pose.translation for one in self.robots.values()]
        distance = min((float(np.linalg.norm(tool - point)) for tool in tools), default=math.inf)
        return 1.0 - math.tanh(distance / NEAR)
