"""The hand that grips, as its compiled model shows it."""

from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError
from bt_manip.robots import Robot

_SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))  # (8, 3) corners of a box


class Hand(NamedTuple):
    """Lengths of a hand with its fingers open, seen from the tool.

    `GripperClearance` measures what depends on where the hand is.
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


def hand_geoms(model: mujoco.MjModel, robot: Robot) -> list[int]:
    """List the geoms that move with a robot's tool and can touch: hand and fingers."""
    weld = model.body_weldid[model.site_bodyid[robot.tool_site_id]]
    moves = np.zeros(model.nbody, dtype=bool)
    if weld:
        moves[weld] = True
        for body in range(weld + 1, model.nbody):  # a parent always comes before its children
            moves[body] = moves[model.body_parentid[body]]
    solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return [int(geom) for geom in np.flatnonzero(moves[model.geom_bodyid] & solid)]


def measure_hand(robot: Robot, placed: dict[int, pin.SE3]) -> Hand:
    """Measure a robot's hand.

    Args:
        robot: A compiled robot.
        placed: Pose of each geom of the hand in the tool, with the fingers open.

    Raises:
        MotionError: When the robot has no two fingers.
    """
    fingers = robot.finger_geom_ids
    if robot.description.gripper is None or len(fingers) != 2:
        raise MotionError(
            f"robot '{robot.description.name}' has no two fingers to grip with", reason="grasp"
        )
    model, travel = robot.mj_model, robot.gripper_travel
    boxes = {geom: _corners(model, geom, T) for geom, T in placed.items()}
    first, second = (np.concatenate([boxes[g] for g in geoms]) for geoms in fingers)
    between = 0.5 * (second.min(0) + second.max(0) - first.min(0) - first.max(0))
    between[2] = 0.0
    closing = -between / np.linalg.norm(between)
    both = np.concatenate([first, second])
    tips = both[both[:, 2] > both[:, 2].max() - 0.02]
    across = np.cross([0.0, 0.0, 1.0], closing)
    welded = model.body_weldid[model.site_bodyid[robot.tool_site_id]]
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
