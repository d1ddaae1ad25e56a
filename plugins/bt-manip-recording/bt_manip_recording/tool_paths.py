"""The path of the tool along a trajectory, to be drawn."""

from typing import Any

import numpy as np

PATH_SAMPLES = 50
"""Usual number of points of a path."""


def tool_path(model: Any, trajectory: Any, samples: int = PATH_SAMPLES) -> np.ndarray:
    """Return positions of the tool along a trajectory [m].

    Args:
        model: The `bt_manip.robots.RobotModel`; a copy, if the arm goes on meanwhile.
        trajectory: The trajectory.
        samples: Number of positions, at equal times.
    """  # (samples, 3)
    positions, _, _ = trajectory.sample(np.linspace(0.0, trajectory.duration, samples))
    return np.array([model.pose(q).translation for q in positions])
