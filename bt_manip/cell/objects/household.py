"""Bottle, can and mug; the origin is the middle of the bottom."""

from collections.abc import Sequence

import numpy as np

from .primitive_prop import GRIP_DEPTH, PrimitiveProp
from .prop import positive


class Vessel(PrimitiveProp):
    """An upright object that moves freely."""

    category = "graspable"
    free = True
    _height: float

    @property
    def centre_offset(self) -> np.ndarray:
        """Grasp centre from above, in the object's frame [m]."""  # (3,)
        return np.array([0.0, 0.0, max(self._height / 2, self._height - GRIP_DEPTH)])


class Can(Vessel):
    """A tin can."""

    kind = "can"

    def _build(
        self,
        name: str = "can",
        radius: float = 0.033,
        height: float = 0.1,
        mass: float = 0.2,
        friction: float = 0.7,
        colour: Sequence[float] = (0.72, 0.14, 0.16),
    ) -> None:
        """Build the can.

        Args:
            name: Model name.
            radius: Radius [m].
            height: Height [m].
            mass: Mass of the can and what is in it [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, radius=radius, height=height, mass=mass, friction=friction, colour=colour)
        radius, self._height = positive("radius", radius, "m"), positive("height", height, "m")
        self._add("cylinder", (radius, self._height / 2), (0, 0, self._height / 2))
        self._weigh(mass)


class Bottle(Vessel):
    """A bottle with a neck to grip."""

    kind = "bottle"

    def _build(
        self,
        name: str = "bottle",
        radius: float = 0.034,
        height: float = 0.2,
        mass: float = 0.3,
        friction: float = 0.8,
        colour: Sequence[float] = (0.22, 0.46, 0.34, 0.9),
    ) -> None:
        """Build the bottle; belly, shoulder and neck are in proportion.

        Args:
            name: Model name.
            radius: Radius of the belly [m].
            height: Height [m].
            mass: Mass of the bottle and what is in it [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, radius=radius, height=height, mass=mass, friction=friction, colour=colour)
        radius, self._height = positive("radius", radius, "m"), positive("height", height, "m")
        belly, shoulder = 0.55 * self._height, 0.68 * self._height
        self._add("cylinder", (radius, belly / 2), (0, 0, belly / 2))
        for part in range(3):
            step = (shoulder - belly) / 3
            width = radius * (0.9 - 0.17 * part)
            self._add("cylinder", (width, step / 2), (0, 0, belly + (part + 0.5) * step))
        neck = self._height - shoulder
        self._add("cylinder", (0.45 * radius, neck / 2), (0, 0, shoulder + neck / 2))
        self._weigh(mass)


class Mug(Vessel):
    """A mug with a handle, hollow."""

    kind = "mug"

    def _build(
        self,
        name: str = "mug",
        radius: float = 0.032,
        height: float = 0.085,
        wall: float = 0.004,
        mass: float = 0.2,
        friction: float = 0.7,
        colour: Sequence[float] = (0.90, 0.89, 0.84),
    ) -> None:
        """Build the mug; its handle is along x.

        Args:
            name: Model name.
            radius: Outer radius [m].
            height: Height [m].
            wall: Thickness of wall and bottom [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(
            name, radius=radius, height=height, wall=wall, mass=mass, friction=friction,
            colour=colour,
        )  # fmt: skip
        radius, wall = positive("radius", radius, "m"), positive("wall", wall, "m")
        self._height = positive("height", height, "m")
        inner = radius - wall
        self._add("cylinder", (inner, wall / 2), (0, 0, wall / 2))
        self._ring(inner, wall, self._height, 0.0)
        out, grip = radius + 0.022, 0.0045
        for z in (0.25 * self._height, 0.75 * self._height):
            self._add("box", (0.012, grip, grip), (radius + 0.01, 0, z))
        self._add("box", (grip, grip, 0.25 * self._height + grip), (out, 0, self._height / 2))
        self._weigh(mass)
