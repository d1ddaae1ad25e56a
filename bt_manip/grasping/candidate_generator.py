"""Generate the grasp candidates of an object."""

from collections.abc import Sequence

import numpy as np

from bt_manip.exceptions import MotionError

from .antipodal_grasps import (
    AntipodalGrasp,
    box_grasps,
    cylinder_grasps,
    sampled_grasps,
    set_depth,
    sphere_grasps,
)
from .antipodal_sampling import best_antipodal_pairs
from .grasp_candidate import GraspTable
from .hand import Hand
from .solids import Solid, least_width

MAX_PRIMITIVES = 8  # solids of an object that are gripped one by one
_PRIMITIVES = {
    "box": box_grasps,
    "cylinder": cylinder_grasps,
    "capsule": cylinder_grasps,
    "sphere": sphere_grasps,
}


class CandidateGenerator:
    """Generates the grasp candidates of one object, in whatever orientation it lies.

    Boxes, cylinders, capsules and spheres are gripped by their geometry, up to `MAX_PRIMITIVES` of
    them in one object. For any other object antipodal pairs are sampled, once.

    Attributes:
        name: Name of the object, for messages.
        solids: Its convex solids.
        hand: The gripper.
        com: Its centre of mass, in its frame [m].  # (3,)
        primitive: Whether it is a single primitive.
    """

    def __init__(
        self,
        name: str,
        solids: Sequence[Solid],
        hand: Hand,
        com: np.ndarray,
        rng: np.random.Generator,
    ) -> None:
        """Sample the object where its geometry is not made of primitives.

        Args:
            name: Name of the object.
            solids: Its convex solids.
            hand: The gripper.
            com: Its centre of mass, in its frame [m].  # (3,)
            rng: Random generator for points on its surface.
        """
        self.name, self.solids, self.hand, self.com = name, list(solids), hand, np.array(com)
        few = len(self.solids) <= MAX_PRIMITIVES
        self._primitives = [
            (i, s) for i, s in enumerate(self.solids) if few and s.kind in _PRIMITIVES
        ]
        all_primitive = len(self._primitives) == len(self.solids)
        self.primitive = all_primitive and len(self.solids) == 1
        self._sampled = (
            None if all_primitive else best_antipodal_pairs(self.solids, hand, self.com, rng)
        )

    def candidates(self, down: np.ndarray) -> GraspTable:
        """List the grasps that do not come from below.

        Args:
            down: Straight down in the object's frame; unit.  # (3,)

        Raises:
            MotionError: When the object is too wide or too thin for the gripper.
        """
        grasps: list[AntipodalGrasp] = []
        if self._sampled is not None:
            grasps += sampled_grasps(self.solids, *self._sampled, down)
        for i, solid in self._primitives:
            found = _PRIMITIVES[solid.kind](solid, self.hand, down)
            grasps += [grasp._replace(part=i) for grasp in found]
        if not grasps:
            raise MotionError(self._no_fit(), reason="grasp")
        table = set_depth(grasps, self.hand, self.solids)
        if not len(table):
            raise MotionError(
                f"'{self.name}' cannot be gripped deep enough: the fingers extend "
                f"{1e3 * (self.hand.tip + self.hand.palm):.0f} mm beyond the palm",
                reason="grasp",
            )
        return table

    def _no_fit(self) -> str:
        width = least_width(self.solids)
        stroke = f"the fingers open to {1e3 * self.hand.stroke:.0f} mm"
        if self.hand.least + 5e-4 < width <= self.hand.stroke:
            return f"'{self.name}' has no antipodal pair of contact points; {stroke}"
        return f"'{self.name}' is at least {1e3 * width:.0f} mm wide; {stroke}"
