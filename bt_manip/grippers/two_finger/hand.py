"""Dimensions of a two-finger gripper, measured on its compiled model."""

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from .mechanism import Mechanism

_SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))  # (8, 3) corners of a box


class Hand(NamedTuple):
    """Dimensions of a hand with its fingers open, in the tool frame.

    `bt_manip.grasping.GripperClearance` measures the clearance at a given pose of the hand.
    """

    closing: np.ndarray
    """Direction between the fingers in the tool frame, orthogonal to its z axis; unit."""  # (3,)
    stroke: float
    """Maximum opening [m]."""
    least: float
    """Minimum opening [m]."""
    tip: float
    """Distance of the fingertips beyond the tool centre point [m]."""
    palm: float
    """Distance of the palm behind the tool centre point [m]."""
    pad: float
    """Half the width of a finger [m]."""

    def opening(self, width: np.ndarray) -> np.ndarray:
        """Return the relative opening at widths [m]: 1 for open, 0 for closed."""
        return (width - self.least) / (self.stroke - self.least)


def measure_hand(
    model: mujoco.MjModel, mechanism: Mechanism, tool_site: int, placed: Mapping[int, pin.SE3]
) -> Hand:
    """Return the dimensions of a gripper.

    Args:
        model: The compiled model.
        mechanism: The gripper's mechanism.
        tool_site: Id of the tool's site.
        placed: Pose in the tool frame of each geom that moves with the tool, fingers open.
    """
    fingers, travel = mechanism.geoms, mechanism.travel
    boxes = {geom: _corners(model, geom, T) for geom, T in placed.items()}
    first, second = (np.concatenate([boxes[g] for g in geoms]) for geoms in fingers)
    closing = travel.closing
    both = np.concatenate([first, second])
    tips = both[both[:, 2] > both[:, 2].max() - 0.02]
    across = np.cross([0.0, 0.0, 1.0], closing)
    welded = model.body_weldid[model.site_bodyid[tool_site]]
    palm = [
        corners[:, 2].max()
        for geom, corners in boxes.items()
        if model.body_weldid[model.geom_bodyid[geom]] == welded
    ]
    return Hand(
        closing,
        travel.open_width,
        travel.min_width,
        float(both[:, 2].max()),
        -float(max(palm, default=-np.inf)),
        float(np.abs(tips @ across).max()),
    )


def _corners(model: mujoco.MjModel, geom: int, T_tg: pin.SE3) -> np.ndarray:
    """Return the corners of a geom's bounding box, in the tool frame [m]."""  # (8, 3)
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    return np.array((centre + _SIGNS * half) @ T_tg.rotation.T + T_tg.translation)
