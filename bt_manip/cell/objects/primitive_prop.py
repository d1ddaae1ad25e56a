"""The base class of objects of primitive shapes."""

import math
from collections.abc import Sequence
from typing import Any

from dm_control import mjcf

from .prop import Prop, colour_of, positive

# As stiff as other objects; with MuJoCo's default, fingers sink 3.4 mm into each side at 50 N.
_SOLREF = (0.004, 1.0)
_VOLUME = {
    "box": lambda s: 8.0 * s[0] * s[1] * s[2],
    "sphere": lambda s: 4.0 / 3.0 * math.pi * s[0] ** 3,
    "cylinder": lambda s: 2.0 * math.pi * s[0] ** 2 * s[1],
    "capsule": lambda s: 2.0 * math.pi * s[0] ** 2 * s[1] + 4.0 / 3.0 * math.pi * s[0] ** 3,
    "mesh": lambda _: 1.0,  # always the only shape
}
_UNITS = {"mass": "kg", "friction": "-"}  # of parameters that are not lengths


class PrimitiveProp(Prop):
    """An object of primitive shapes that are both visible and collide.

    All have the ``mass`` [kg] of a free object, a coefficient of sliding ``friction`` [-], and a
    ``colour``: red, green, blue, and optionally opacity, from 0 to 1. Subclasses declare these and
    their own parameters in ``defaults``, and create their shapes in ``_add_shapes``. Parameters
    whose default is a float or a tuple are positive lengths. The origin is the centre of the bottom
    unless a subclass says otherwise.
    """

    @property
    def mass(self) -> float:
        """Mass of all of it [kg]."""
        return float(self._parameters["mass"])

    def _make_model(self, name: str) -> None:
        self._mjcf_root = root = mjcf.RootElement(model=name)
        root.compiler.angle = "radian"
        values = {key: self._checked(key, value) for key, value in self._parameters.items()}
        mass, friction, self._rgba = (values.pop(key) for key in ("mass", "friction", "colour"))
        root.default.geom.set_attributes(solref=_SOLREF, friction=(friction, 0.005, 0.0001))
        self._body = root.worldbody.add("body", name=self.kind)
        self._add_shapes(**values)
        geoms = self._all_geoms()
        volumes = [_VOLUME[geom.type](geom.size) for geom in geoms]
        for geom, volume in zip(geoms, volumes, strict=True):
            geom.mass = mass * volume / sum(volumes)

    def _checked(self, name: str, value: Any) -> Any:
        """Check a parameter by the type of its default."""
        default = self.defaults[name]
        if name == "colour":
            return colour_of(value)
        if isinstance(default, float):
            return positive(name, value, _UNITS.get(name, "m"))
        if not isinstance(default, tuple):
            return value
        return tuple(positive(name, length, "m") for length in value)

    def _add_shapes(self, *_: Any, **parameters: Any) -> None:
        """Add all shapes for the parameters of the subclass."""
        raise NotImplementedError

    def _add(
        self,
        type: str,
        size: Sequence[float],
        pos: Sequence[float] = (0.0, 0.0, 0.0),
        *,
        euler: Sequence[float] = (0.0, 0.0, 0.0),
        name: str | None = None,
    ) -> mjcf.Element:
        """Add a shape with MuJoCo's ``size``: half lengths or radii [m]."""
        return self._body.add(
            "geom", name=name, type=type, size=size, pos=pos, euler=euler, rgba=self._rgba
        )

    def _add_ring(
        self,
        inner: float,
        thickness: float,
        height: float,
        centre: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Add a wall around a vertical axis, of 16 flat sides tangential to a circle.

        Args:
            inner: Radius of the circle [m].
            thickness: Thickness of the wall [m].
            height: Height of the wall [m].
            centre: Centre of the circle [m].
        """
        (u, v), sides = centre, 16
        middle = inner + thickness / 2
        half_width = (inner + thickness) * math.tan(math.pi / sides)
        for i in range(sides):
            angle = 2 * math.pi * i / sides
            pos = (u + middle * math.cos(angle), v + middle * math.sin(angle), height / 2)
            self._add("box", (thickness / 2, half_width, height / 2), pos, euler=(0, 0, angle))
