"""The grasps that come into question for an object."""

from collections.abc import Sequence

import numpy as np

from bt_manip.exceptions import MotionError

from .box import box_pinches
from .cylinder import cylinder_pinches
from .grasp import GraspTable
from .hand import Hand
from .mesh import mesh_pinches, sampled_pairs
from .pinch import Pinch, grasps_of
from .solid import Solid
from .sphere import sphere_pinches

MANY = 8  # solids of an object that are looked at one by one
_SHAPES = {
    "box": box_pinches,
    "cylinder": cylinder_pinches,
    "capsule": cylinder_pinches,
    "sphere": sphere_pinches,
}

SampledPairs = list[tuple[np.ndarray, np.ndarray, float, float]]


class Candidates:
    """Lists the grasps of one object, however it lies.

    Boxes, cylinders, capsules and balls are gripped where their shape says, up to eight of them in
    one object. Anything else, and what is put together of more, is gripped at pairs of places that
    are sampled, once.
    """

    def __init__(
        self,
        name: str,
        solids: Sequence[Solid],
        hand: Hand,
        centre: np.ndarray,
        rng: np.random.Generator,
    ) -> None:
        """Look at an object.

        Args:
            name: What it is called, for reasons.
            solids: What it is made of.
            hand: What is to grip it.
            centre: Its centre of mass, in its frame [m].  # (3,)
            rng: What places on its surface are drawn from.
        """
        self.name, self.solids, self.hand = name, list(solids), hand
        shaped = len(self.solids) <= MANY and all(solid.kind in _SHAPES for solid in self.solids)
        self.simple = shaped and len(self.solids) == 1
        self.centre = np.array(centre)
        self._pairs: SampledPairs = []
        if not shaped:
            self._pairs = sampled_pairs(self.solids, hand, self.centre, rng)

    def grasps(self, down: np.ndarray) -> GraspTable:
        """List grasps that do not come from below.

        Args:
            down: Straight down, in the object's frame; unit.  # (3,)

        Raises:
            MotionError: When the object is too wide or too thin for the hand, with both lengths.
        """
        pinches: list[Pinch] = list(mesh_pinches(self.solids, self._pairs, down))
        for part, solid in enumerate(self.solids if len(self.solids) <= MANY else ()):
            if solid.kind in _SHAPES:
                found = _SHAPES[solid.kind](solid, self.hand, down)
                pinches += [pinch._replace(part=part) for pinch in found]
        if not pinches:
            raise MotionError(self._no_fit(), reason="grasp")
        table = grasps_of(pinches, self.hand, self.solids)
        if not len(table):
            raise MotionError(
                f"'{self.name}' is out of the fingers' depth: between their tips and the palm are "
                f"{1e3 * (self.hand.tip + self.hand.palm):.0f} mm",
                reason="grasp",
            )
        return table

    def _no_fit(self) -> str:
        narrowest = least_width(self.solids)
        stroke = f"the fingers open to {1e3 * self.hand.stroke:.0f} mm"
        if narrowest > self.hand.least + 5e-4 and narrowest <= self.hand.stroke:
            return f"no two sides of '{self.name}' face each other between fingers; {stroke}"
        return f"'{self.name}' is {1e3 * narrowest:.0f} mm wide where it is narrowest; {stroke}"


def least_width(solids: Sequence[Solid]) -> float:
    """Give the least distance of two parallel planes that an object is between [m].

    For a single box, cylinder, capsule or ball exactly, for others among the normals of faces.
    """
    only = solids[0]
    if len(solids) == 1 and only.kind == "box":
        return 2.0 * float(only.size.min())
    if len(solids) == 1 and only.kind == "sphere":
        return 2.0 * float(only.size[0])
    if len(solids) == 1 and only.kind in ("cylinder", "capsule"):
        end = only.size[1] + (only.size[0] if only.kind == "capsule" else 0.0)
        return 2.0 * float(min(only.size[0], end))
    normals = np.concatenate([solid.polyhedron.normals for solid in solids])
    there, back = (np.max([s.reach(d) for s in solids], axis=0) for d in (normals, -normals))
    return float((there + back).min())
