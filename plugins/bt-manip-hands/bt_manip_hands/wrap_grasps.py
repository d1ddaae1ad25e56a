"""Power grasps that wrap a hand around an object."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError
from bt_manip.grippers import Solid
from bt_manip.robots import GraspCandidates

_FINGER_CLEARANCE = 5e-3  # [m] of the fingertips above the object's far side, and of the palm
_SLACK = 8e-3  # [m] total clearance of the object between the open thumb and fingers
_BELOW = -0.1  # cosine of approach and straight down, below which a grasp approaches from below
_FARTHER = (0.0, 0.01, 0.02)  # [m] additional distances of the tool if links obstruct the nearest
_CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))  # (8, 3) of a box
DEPTH_WEIGHT = 0.5
"""Cost of a grasp with the tool short of the object's centre by the reach of a fingertip."""


class HandShape(NamedTuple):
    """Dimensions of the open hand, in the tool frame."""

    closing: np.ndarray
    """Direction from the thumb to the fingers, orthogonal to the z axis; unit."""  # (3,)
    tip: float
    """Distance of the fingertips beyond the tool centre point [m]."""
    palm: float
    """Distance of the palm behind the tool centre point [m]."""
    max_width: float
    """Width of the widest object between thumb and fingers [m]."""


def measure(
    model: mujoco.MjModel,
    geom_poses: Mapping[int, pin.SE3],
    thumb: Sequence[int],
    fingers: Sequence[int],
    palm: Sequence[int],
    max_width: float,
) -> HandShape:
    """Return the dimensions of a hand by the geoms of its parts, posed in the tool frame."""
    first, second, back = (
        np.concatenate([_corners(model, geom, geom_poses[geom]) for geom in geoms])
        for geoms in (thumb, fingers, palm)
    )
    across = second.mean(axis=0) - first.mean(axis=0)
    across[:2] = across[:2] * (np.abs(across[:2]) == np.abs(across[:2]).max())  # along an axis
    across[2] = 0.0
    tip = max(first[:, 2].max(), second[:, 2].max())
    closing = across / np.linalg.norm(across)
    return HandShape(closing, float(tip), -float(back[:, 2].max()), max_width)


class WrapGraspGenerator:
    """Generates grasps with thumb and fingers on opposite sides of an object's bounding box.

    The box is aligned with the object's only solid, or with the object. The tool is at the centre
    of the box if the palm and the support allow it.

    Attributes:
        com: The object's centre of mass, in its frame [m].  # (3,)
    """

    def __init__(
        self, name: str, solids: Sequence[Solid], shape: HandShape, com: np.ndarray
    ) -> None:
        self.name, self.com, self._shape = name, np.array(com), shape
        self._axes = solids[0].T_os.rotation if len(solids) == 1 else np.eye(3)
        upper, lower = (
            np.max([solid.support(sign * self._axes.T) for solid in solids], axis=0)
            for sign in (1.0, -1.0)
        )
        self._half = 0.5 * (upper + lower)
        self._centre = self._axes @ (0.5 * (upper - lower))

    def candidates(self, down: np.ndarray) -> GraspCandidates:
        """Return all grasps except those that approach from below.

        Raises:
            MotionError: If the hand cannot wrap the object; the message has the reason.
        """
        shape, half = self._shape, self._half
        rotations, positions, widths, losses = [], [], [], []
        for closing, along, farther in product(range(3), range(3), _FARTHER):
            width = 2.0 * half[closing]
            if closing == along or width > shape.max_width - _SLACK:
                continue
            # The tool stays behind the centre if fingertips or palm lack clearance.
            back = farther + max(
                0.0,
                shape.tip + _FINGER_CLEARANCE - half[along],
                half[along] + _FINGER_CLEARANCE - shape.palm,
            )
            if back > half[along]:
                continue
            for sign_closing, sign in product((1.0, -1.0), repeat=2):
                approach = sign * self._axes[:, along]
                if approach @ down < _BELOW:
                    continue
                x = sign_closing * self._axes[:, closing]
                object_axes = np.column_stack([x, np.cross(approach, x), approach])
                z = np.array([0.0, 0.0, 1.0])
                tool_axes = np.column_stack([shape.closing, np.cross(z, shape.closing), z])
                rotations.append(object_axes @ tool_axes.T)
                positions.append(self._centre - back * approach)
                widths.append(width)
                losses.append(back / half[along])
        if not rotations:
            raise MotionError(
                f"'{self.name}' does not fit the hand: it is {1e3 * 2.0 * half.min():.0f} mm wide, "
                f"the hand takes {1e3 * (shape.max_width - _SLACK):.0f} mm, "
                f"{1e3 * (shape.tip + shape.palm):.0f} mm deep",
                reason="grasp",
            )
        n = len(rotations)
        depth = DEPTH_WEIGHT * np.clip(losses, 0.0, 1.0)
        return GraspCandidates(
            np.array(rotations), np.array(positions), np.array(widths), np.ones(n), {"depth": depth}
        )


def _corners(model: mujoco.MjModel, geom: int, T_tg: pin.SE3) -> np.ndarray:
    """Return the corners of a geom's bounding box, in the tool frame [m]."""  # (8, 3)
    centre, half = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
    return np.array((centre + _CORNERS * half) @ T_tg.rotation.T + T_tg.translation)
