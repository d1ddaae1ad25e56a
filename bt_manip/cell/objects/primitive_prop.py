"""The base class of objects of primitive shapes."""

import math
from collections.abc import Sequence
from typing import Any

from dm_control import mjcf

from bt_manip.parameters import Parameter

from .prop import Prop

# As stiff as other objects; with MuJoCo's default, fingers sink 3.4 mm into each side at 50 N.
_SOLREF = (0.004, 1.0)
_VOLUME = {
    "box": lambda s: 8.0 * s[0] * s[1] * s[2],
    "sphere": lambda s: 4.0 / 3.0 * math.pi * s[0] ** 3,
    "cylinder": lambda s: 2.0 * math.pi * s[0] ** 2 * s[1],
    "capsule": lambda s: 2.0 * math.pi * s[0] ** 2 * s[1] + 4.0 / 3.0 * math.pi * s[0] ** 3,
    "mesh": lambda _: 1.0,  # always the only shape
}


def length(meaning: str, default: float | tuple[float, ...]) -> Parameter:
    """Declare a parameter that is a length [m], or several."""
    return Parameter(meaning, "m", default, above=0.0)


class PrimitiveProp(Prop):
    """An object of primitive shapes that are both visible and collide.

    Subclasses set the defaults of these parameters and declare their own in ``defaults``, and
    create their shapes in ``_add_shapes``. A default that is a float or a tuple declares positive
    lengths. The origin is the centre of the bottom unless a subclass says otherwise.
    """

    defaults = {
        "mass": Parameter(
            "Mass; it counts where the object is free", "kg", 0.1, above=0.0, at_most=1e10
        ),
        "friction": Parameter("Coefficient of sliding friction", "", 1.0, above=0.0),
        "colour": Parameter(
            "Red, green, blue, and opacity where given", "", (0.5, 0.5, 0.5),
            size=(3, 4), at_least=0.0, at_most=1.0,
        ),
    }  # fmt: skip

    @classmethod
    def _like(cls, default: Any) -> Parameter:
        return length("", default) if isinstance(default, float | tuple) else super()._like(default)

    @property
    def mass(self) -> float:
        """Mass of all of it [kg]."""
        return float(self._parameters["mass"])

    def _make_model(self, name: str) -> None:
        self._mjcf_root = root = mjcf.RootElement(model=name)
        root.compiler.angle = "radian"
        values = dict(self._parameters)
        mass, friction, colour = (values.pop(key) for key in ("mass", "friction", "colour"))
        self._rgba = (*colour, 1.0)[:4]
        root.default.geom.set_attributes(solref=_SOLREF, friction=(friction, 0.005, 0.0001))
        self._body = root.worldbody.add("body", name=self.kind)
        self._add_shapes(**values)
        geoms = self._all_geoms()
        volumes = [_VOLUME[geom.type](geom.size) for geom in geoms]
        for geom, volume in zip(geoms, volumes, strict=True):
            geom.mass = mass * volume / sum(volumes)

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
