"""Grasps of two fingers declared by an object."""

from collections.abc import Sequence

import numpy as np

from bt_manip.cell.objects import DeclaredGrasp
from bt_manip.exceptions import MotionError
from bt_manip.robots import GraspCandidates

from .hand import BELOW, CLOSING_MARGIN, Hand


class DeclaredGraspGenerator:
    """Generates grasp candidates from an object's declared grasps.

    Args:
        name: Name of the object, for messages.
        grasps: Its declared grasps.
        hand: The gripper.

    Attributes:
        com: The object's centre of mass, in its frame [m].  # (3,)
    """

    def __init__(
        self, name: str, grasps: Sequence[DeclaredGrasp], hand: Hand, com: np.ndarray
    ) -> None:
        self._name, self._grasps, self._hand, self.com = name, list(grasps), hand, np.array(com)

    def candidates(self, down: np.ndarray) -> GraspCandidates:
        """Return the grasps that fit and do not approach from below, with either finger first.

        Args:
            down: Straight down in the object's frame; unit.  # (3,)

        Raises:
            MotionError: If no grasp fits between the fingers.
        """
        hand, fit = self._hand, [g for g in self._grasps if g.width < self._hand.stroke]
        if not fit:
            least = 1e3 * min(grasp.width for grasp in self._grasps)
            raise MotionError(
                f"'{self._name}' declares grasps of {least:.0f} mm or more, and the gripper opens "
                f"{1e3 * hand.stroke:.0f} mm",
                reason="grasp",
            )
        grasps = [g for g in fit if g.T_og.rotation[:, 2] @ down >= BELOW]
        if not grasps:
            raise MotionError(
                f"'{self._name}' declares no grasp that approaches from above or from the side",
                reason="grasp",
            )
        closing = np.array([s * g.T_og.rotation[:, 1] for g in grasps for s in (1.0, -1.0)])
        approach = np.array([g.T_og.rotation[:, 2] for g in grasps for _ in range(2)])
        width = np.array([g.width for g in grasps for _ in range(2)])
        centre = np.array([g.T_og.translation for g in grasps for _ in range(2)])
        return GraspCandidates(
            hand.rotations(closing, approach),
            centre - hand.offset(width)[:, None] * closing,
            width,
            hand.opening(np.minimum(width + 2.0 * CLOSING_MARGIN, hand.stroke)),
            {},
            closing=hand.closing,
        )
