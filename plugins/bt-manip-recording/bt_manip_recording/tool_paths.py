"""The path of the tool along a trajectory, to be drawn."""

from typing import Any

import numpy as np

PATH_SAMPLES = 50
"""Number of points of a path, at equal times."""


def tool_path(model: Any, trajectory: Any) -> np.ndarray:
    """Return positions of the tool along a trajectory [m].

    Args:
        model: The `bt_manip.robots.RobotModel`; a copy, if the arm goes on meanwhile.
        trajectory: The trajectory.
    """  # (PATH_SAMPLES, 3)
    positions, _, _ = trajectory.sample(np.linspace(0.0, trajectory.duration, PATH_SAMPLES))
    return np.array([model.pose(q).translation for q in positions])
