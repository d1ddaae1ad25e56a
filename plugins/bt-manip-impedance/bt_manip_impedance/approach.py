"""Conditions whose progress begins with the approach of a robot."""

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from bt_manip.behaviours import ObjectCondition

NEAR = 0.2
"""Distance of the nearest tool at which the progress of approaching is a quarter [m]."""


class ApproachCondition(ObjectCondition):
    """A condition on an object that some robot approaches."""

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell and the robots."""
        super().setup(**infrastructure)
        self.robots: Mapping[str, Any] = infrastructure.get("robots", {})

    def closeness(self, point: np.ndarray) -> float:
        """Return how close the nearest tool is to a point in the world: 1 there, 0 far away."""
        tools = [one.robot.tool_pose.translation for one in self.robots.values()]
        distance = min(float(np.linalg.norm(tool - point)) for tool in tools)
        return 1.0 - math.tanh(distance / NEAR)
