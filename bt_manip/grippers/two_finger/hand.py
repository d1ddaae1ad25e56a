"""Lengths of a gripper of two fingers, as its compiled model shows them."""

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from .mechanism import Mechanism

_SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))  # (8, 3) corners of a box


class Hand(NamedTuple):
    """Lengths of a hand with its fingers open, seen from the tool.

    `bt_manip.grasping.GripperClearance` measures what depends on where the hand is.
    """

    closing: np.ndarray
    """Direction from one finger to the other, in the tool's frame; across its z axis."""  # (3,)
    stroke: float
    """How far the fingers open [m]."""
    least: float
    """Opening with the fingers together [m]."""
    tip: float
    """How far the fingers reach beyond the tool's centre [m]."""
    palm: float
    """How far behind the tool's centre the palm is [m]."""
    pad: float
    """Half the width of a finger [m]."""
    friction: float
    """Sliding friction of the fingers [-]."""

    def opening(self, width: np.ndarray) -> np.ndarray:
        """Give how far the gripper is open at widths [m]: 1 for all the way, 0 for closed."""
        return (width - self.least) / (self.stroke - self.least)


def measure_hand(
    model: mujoco.MjModel, mechanism: Mechanism, tool_site: int, placed: Mapping[int, pin.SE3]
) -> Hand:
    """Measure a gripper.

    Args:
        model: What it is compiled into.
        mechanism: Its fingers.
        tool_site: Id of the tool's site.
        placed: Pose of each geom that moves with the tool in the tool, with the fingers open.
    """
    fingers, travel = mechanism.geoms, mechanism.travel
    boxes = {geom: _corners(model, geom, T) for geom, T in placed.items()}
    first, second = (np.concatenate([boxes[g] for g in geoms]) for geoms in fingers)
    between = 0.5 * (second.min(0) + second.max(0) - first.min(0) - first.max(0))
    between[2] = 0.0
    closing = -between / np.linalg.norm(between)
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
        float(min(model.geom_friction[g, 0] for geoms in fingers for g in geoms)),
    )


def _corners(model: mujoco.MjModel, geom: int, T_tg: pin.SE3) -> np.ndarray:
    """Give the corners of the box around a geom, in the tool's frame."""  # (8, 3)
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    return np.array((centre + _SIGNS * half) @ T_tg.rotation.T + T_tg.translation)
