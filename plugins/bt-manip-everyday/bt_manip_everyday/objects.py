"""Kitchen objects."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.cell.objects import Can, DeclaredGrasp, Mug, PrimitiveProp
from bt_manip.parameters import Parameter

GRIP = 0.009
"""Width of the handle's bars [m]."""

TILTS = ((np.pi / 3, 0.68), (np.pi / 4, 0.5), (np.pi / 6, 0.5))
"""Approaches to a handle: angle below the horizontal [rad], and height relative to the mug's."""

FOOT = 0.6
"""Radius of a bowl's foot, relative to that of its rim."""

RIM_DEPTH = 0.012
"""Depth of a bowl's grasps below its rim [m]."""


class CoffeeMug(Mug):
    """A hollow mug, gripped by its handle, along x."""

    kind = "coffee_mug"
    defaults = {
        **Mug.defaults,
        "radius": 0.038,
        "height": 0.095,
        "handle": Parameter(
            "How far the handle stands out, with room for a finger", "m", 0.036, at_least=0.03
        ),
        "colour": (0.16, 0.32, 0.50),
    }

    def _add_shapes(  # type: ignore[override]
        self, radius: float, height: float, wall: float, handle: float
    ) -> None:
        inner, half = radius - wall, GRIP / 2
        self._add("cylinder", (inner, wall / 2), (0, 0, wall / 2))
        self._add_ring(inner, wall, height)
        for z in (0.2 * height, 0.8 * height):
            self._add("box", (handle / 2, half, half), (radius + handle / 2 - wall / 2, 0, z))
        bar = 0.3 * height + half
        self._add("box", (half, half, bar), (radius + handle - half, 0, height / 2), name="bar")

    @property
    def grasps(self) -> Sequence[DeclaredGrasp]:
        """The bar of the handle, approached diagonally from outside."""
        x = float(self.parameters["radius"] + self.parameters["handle"]) - GRIP / 2
        height = float(self.parameters["height"])
        poses = [
            pin.SE3(_towards(-np.cos(a), -np.sin(a)), np.array([x, 0.0, part * height]))
            for a, part in TILTS
        ]
        return [DeclaredGrasp(T_og, GRIP) for T_og in poses]


class Bowl(PrimitiveProp):
    """A round bowl, gripped by its rim."""

    kind = "bowl"
    category = "graspable"
    free = True
    defaults = {
        "radius": Parameter("Outer radius of the rim", "m", 0.07, above=0.0),
        "height": Parameter("Height", "m", 0.055, above=0.0),
        "wall": Parameter("Thickness of wall and bottom", "m", 0.004, above=0.0),
        "mass": 0.2, "friction": 0.7,
        "colour": (0.88, 0.84, 0.74),
    }  # fmt: skip

    def _add_shapes(self, radius: float, height: float, wall: float) -> None:
        foot, sides = FOOT * radius, 16
        self._add("cylinder", (foot, wall / 2), (0, 0, wall / 2))
        self._slope = slope = float(np.arctan2(radius - foot, height))
        length = (height - wall * np.sin(slope)) / np.cos(slope)  # the edges are square
        middle = np.array([(foot + radius - wall) / 2, 0.0, height / 2])
        self._rim = middle + (length / 2) * np.array([np.sin(slope), 0.0, np.cos(slope)])
        size = (wall / 2, radius * np.tan(np.pi / sides), length / 2)
        for angle in 2 * np.pi / sides * np.arange(sides):
            turn = pin.utils.rotate("z", angle)
            tilt = turn @ pin.utils.rotate("y", slope)
            self._add("box", size, turn @ middle, euler=-pin.rpy.matrixToRpy(tilt.T))

    @property
    def centre_offset(self) -> np.ndarray:
        """Centre of the rim in the object's frame [m]."""  # (3,)
        return np.array([0.0, 0.0, float(self.parameters["height"])])

    @property
    def grasps(self) -> Sequence[DeclaredGrasp]:
        """Eight grasps of the rim, approached along the wall; the fingers close across it."""
        into = _towards(-np.sin(self._slope), -np.cos(self._slope))
        place = self._rim + RIM_DEPTH * into[:, 2]
        across = into @ pin.utils.rotate("z", np.pi / 2)
        turns = [pin.utils.rotate("z", angle) for angle in np.pi / 4 * np.arange(8)]
        wall = float(self.parameters["wall"])
        return [DeclaredGrasp(pin.SE3(R @ across, R @ place), wall) for R in turns]


class RedCan(Can):
    """A red can."""

    kind = "red_can"
    defaults = {**Can.defaults, "colour": (0.78, 0.14, 0.14)}


class GreenCan(Can):
    """A green can."""

    kind = "green_can"
    defaults = {**Can.defaults, "colour": (0.20, 0.55, 0.28)}


class BlueCan(Can):
    """A blue can."""

    kind = "blue_can"
    defaults = {**Can.defaults, "colour": (0.16, 0.36, 0.72)}


class YellowCan(Can):
    """A yellow can."""

    kind = "yellow_can"
    defaults = {**Can.defaults, "colour": (0.92, 0.76, 0.18)}


def _towards(x: float, z: float) -> np.ndarray:
    """Return the orientation of a tool that approaches along (x, 0, z) and closes along y."""
    return np.column_stack([(z, 0.0, -x), (0.0, 1.0, 0.0), (x, 0.0, z)])
