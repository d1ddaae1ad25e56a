"""Dimensions of a two-finger gripper, measured on its compiled model."""

from collections.abc import Mapping
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial

from ..solids import BodySurface
from .mechanism import Mechanism

FIXED_JAW_CLEARANCE = 1e-3
"""Clearance between a fixed jaw and the object before the moving jaw closes [m]."""

CLOSING_MARGIN = 3e-3
"""Distance on each side of the contacts within which the fingers may touch the object [m]."""

BELOW = -0.1
"""Cosine of approach and straight down below which a grasp approaches from below."""

_JAW_DEPTH = 0.25  # [openings] from the jaw's face, beyond which its body is a palm
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
    centre: float = 0.0
    """Coordinate along `closing` of the midpoint between the closed fingers [m]."""
    shift: float = 0.0
    """Derivative of this coordinate with respect to the opening: 0.5 with a fixed second finger."""

    def offset(self, width: np.ndarray) -> np.ndarray:
        """Return the coordinate along `closing` of the centre of a gripped object [m].

        A fixed jaw is placed `FIXED_JAW_CLEARANCE` beside the object.

        Args:
            width: Gripped width [m].
        """
        return self.centre + self.shift * (width + 2.0 * FIXED_JAW_CLEARANCE)

    def rotations(self, closing: np.ndarray, approach: np.ndarray) -> np.ndarray:
        """Return the rotations of the tool at grasps, in the grasps' frame.

        Args:
            closing: Directions from one contact to the other.  # (n, 3)
            approach: Approach directions, orthogonal to these.  # (n, 3)
        """  # (n, 3, 3)
        grasp_axes = np.stack([closing, np.cross(approach, closing), approach], axis=2)
        z = np.array([0.0, 0.0, 1.0])
        tool_axes = np.stack([self.closing, np.cross(z, self.closing), z], axis=1)
        return np.asarray(grasp_axes @ tool_axes.T)

    def opening(self, width: np.ndarray) -> np.ndarray:
        """Return the relative opening, 1 for open and 0 for closed, at widths [m]."""
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
    closing = np.array(travel.closing)
    both = np.concatenate([first, second])
    tips = both[both[:, 2] > both[:, 2].max() - 0.02]
    across = np.cross([0.0, 0.0, 1.0], closing)
    welded = model.body_weldid[model.site_bodyid[tool_site]]
    jaw = fingers[1] if travel.one_moves else ()
    palm = [
        corners[:, 2].max()
        for geom, corners in boxes.items()
        if model.body_weldid[model.geom_bodyid[geom]] == welded and geom not in jaw
    ]
    if jaw:
        depth = travel.centre[0] + _JAW_DEPTH * travel.open_width
        palm.append(jaw_height(model, jaw[0], placed[jaw[0]], closing, depth))
    return Hand(
        closing,
        travel.open_width,
        travel.min_width,
        float(both[:, 2].max()),
        -float(max(palm, default=-np.inf)),
        float(np.abs(tips @ across).max()),
        *travel.centre,
    )


def jaw_height(
    model: mujoco.MjModel, geom: int, T_tg: pin.SE3, closing: np.ndarray, depth: float
) -> float:
    """Return the extent of a fixed jaw's body along the approach, between the jaws [m].

    Args:
        model: The compiled model.
        geom: A geom of the body.
        T_tg: Its pose in the tool frame.
        closing: Direction towards the other finger in the tool frame.  # (3,)
        depth: Coordinate along `closing` beyond which the body is between the jaws [m].
    """
    T_bg = spatial.pose(model.geom_pos[geom], model.geom_quat[geom])
    across = np.cross(closing, [0.0, 0.0, 1.0])
    R = np.stack([[0.0, 0.0, 1.0], across, closing])  # to a frame whose z axis is `closing`
    T_fb = pin.SE3(R, np.zeros(3)) * T_tg * T_bg.inverse()
    inside = BodySurface(model, int(model.geom_bodyid[geom])).beyond(T_fb, depth)
    return float(inside[:, 0].max(initial=-np.inf))


def _corners(model: mujoco.MjModel, geom: int, T_tg: pin.SE3) -> np.ndarray:
    """Return the corners of a geom's bounding box, in the tool frame [m]."""  # (8, 3)
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    return np.array((centre + _SIGNS * half) @ T_tg.rotation.T + T_tg.translation)
