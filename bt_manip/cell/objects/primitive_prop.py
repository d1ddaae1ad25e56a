"""The base class of objects built from primitive shapes."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from dm_control import mjcf

from ..exceptions import CellError
from .prop import Prop, colour_of, positive

GRIP_DEPTH = 0.03
"""How far under its top a thing is gripped that is higher than grippers are deep [m]."""

# As stiff as the other objects: with MuJoCo's default a 50 N grip sinks 3.4 mm into each side.
_SOLREF = (0.004, 1.0)
_VOLUME = {
    "box": lambda s: 8.0 * s[0] * s[1] * s[2],
    "sphere": lambda s: 4.0 / 3.0 * math.pi * s[0] ** 3,
    "cylinder": lambda s: 2.0 * math.pi * s[0] ** 2 * s[1],
    "capsule": lambda s: 2.0 * math.pi * s[0] ** 2 * s[1] + 4.0 / 3.0 * math.pi * s[0] ** 3,
}


class PrimitiveProp(Prop):
    """An object of primitive shapes that are both visible and collide.

    Subclasses call ``_begin``, add shapes, and distribute the mass with ``_weigh``. The origin is
    the middle of the bottom unless they say otherwise.
    """

    _mass: float | None = None

    @property
    def mass(self) -> float:
        """Mass of all of it [kg]."""
        return self._mass or 0.0

    def _begin(self, name: str, **parameters: Any) -> None:
        """Begin with an empty body and the parameters that the object was made with."""
        self._parameters = {
            key: list(value) if isinstance(value, tuple | np.ndarray) else value
            for key, value in parameters.items()
        }
        self._mjcf_root = root = mjcf.RootElement(model=name)
        root.compiler.angle = "radian"
        friction = positive("friction", parameters["friction"], "-")
        root.default.geom.set_attributes(solref=_SOLREF, friction=(friction, 0.005, 0.0001))
        self._body = root.worldbody.add("body", name=self.kind)
        self._rgba = colour_of(parameters["colour"])
        self._mass = 0.0

    def _add(
        self,
        type: str,
        size: Sequence[float],
        pos: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        euler: Sequence[float] = (0.0, 0.0, 0.0),
        rgba: Sequence[float] | None = None,
        name: str | None = None,
    ) -> mjcf.Element:
        """Add a shape with MuJoCo's sizes: half lengths, radii [m]."""
        return self._body.add(
            "geom", name=name, type=type, size=size, pos=pos, euler=euler,
            rgba=self._rgba if rgba is None else rgba,
        )  # fmt: skip

    def _ring(
        self, inner: float, thickness: float, height: float, bottom: float, sides: int = 16
    ) -> None:
        """Add a wall around the vertical axis: flat sides, tangential to a circle [m].

        Args:
            inner: Radius of the circle.
            thickness: Of the wall.
            height: Of the wall.
            bottom: Height at which it begins.
            sides: How many.
        """
        middle = inner + thickness / 2
        half_width = (inner + thickness) * math.tan(math.pi / sides)
        for i in range(sides):
            angle = 2 * math.pi * i / sides
            place = (middle * math.cos(angle), middle * math.sin(angle), bottom + height / 2)
            self._add("box", (thickness / 2, half_width, height / 2), place, euler=(0, 0, angle))

    def _weigh(self, mass: float) -> None:
        """Distribute a mass [kg] over the shapes by volume."""
        self._mass = positive("mass", mass, "kg")
        geoms = self._all_geoms()
        volumes = [_VOLUME[geom.type](geom.size) for geom in geoms]
        for geom, volume in zip(geoms, volumes, strict=True):
            geom.mass = self._mass * volume / sum(volumes)


def lengths(name: str, values: Sequence[float], count: int = 3) -> tuple[float, ...]:
    """Check several lengths [m].

    Raises:
        CellError: If one is not positive, or the count is wrong.
    """
    if len(values) != count:
        raise CellError(f"{name} is {count} lengths [m], got {tuple(values)}")
    return tuple(positive(name, value, "m") for value in values)
