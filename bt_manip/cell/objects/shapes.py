"""Objects of a single convex shape; the origin is the centre."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from ..exceptions import CellError
from .primitive_prop import GRIP_DEPTH, PrimitiveProp, lengths
from .prop import positive

Colour = Sequence[float]


class Shape(PrimitiveProp):
    """One convex body that moves freely; its origin is its centre."""

    category = "graspable"
    free = True
    _half_height: float

    @property
    def rest_height(self) -> float:
        """Height of the origin above the surface that it rests on [m]."""
        return self._half_height

    @property
    def centre_offset(self) -> np.ndarray:
        """Grasp centre from above, in the object's frame [m]."""  # (3,)
        return np.array([0.0, 0.0, max(0.0, self._half_height - GRIP_DEPTH)])


class Box(Shape):
    """A box."""

    kind = "box"

    def _build(
        self,
        name: str = "box",
        size: Sequence[float] = (0.06, 0.04, 0.04),
        mass: float = 0.1,
        friction: float = 1.0,
        colour: Colour = (0.72, 0.53, 0.33),
    ) -> None:
        """Build the box.

        Args:
            name: Model name.
            size: Lengths along x, y and z [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, size=size, mass=mass, friction=friction, colour=colour)
        x, y, z = lengths("size", size)
        self._half_height = z / 2
        self._add("box", (x / 2, y / 2, z / 2))
        self._weigh(mass)


class Cylinder(Shape):
    """A cylinder that stands on its end."""

    kind = "cylinder"

    def _build(
        self,
        name: str = "cylinder",
        radius: float = 0.02,
        height: float = 0.05,
        mass: float = 0.1,
        friction: float = 1.0,
        colour: Colour = (0.42, 0.56, 0.68),
    ) -> None:
        """Build the cylinder.

        Args:
            name: Model name.
            radius: Radius [m].
            height: Height [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, radius=radius, height=height, mass=mass, friction=friction, colour=colour)
        radius, height = positive("radius", radius, "m"), positive("height", height, "m")
        self._half_height = height / 2
        self._add("cylinder", (radius, height / 2))
        self._weigh(mass)


class Sphere(Shape):
    """A ball; it rolls, but not for ever."""

    kind = "sphere"

    def _build(
        self,
        name: str = "sphere",
        radius: float = 0.025,
        mass: float = 0.05,
        friction: float = 1.0,
        rolling_friction: float = 5e-4,
        colour: Colour = (0.80, 0.36, 0.30),
    ) -> None:
        """Build the ball.

        Args:
            name: Model name.
            radius: Radius [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            rolling_friction: Length of the lever arm of rolling friction [m].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(
            name, radius=radius, mass=mass, friction=friction, rolling_friction=rolling_friction,
            colour=colour,
        )  # fmt: skip
        self._half_height = positive("radius", radius, "m")
        rolling = positive("rolling_friction", rolling_friction, "m")
        geom = self._add("sphere", (self._half_height,))
        geom.condim = 6  # rolling friction counts from six dimensions on
        geom.friction = (friction, 0.005, rolling)
        self._weigh(mass)


class Capsule(Shape):
    """A cylinder with round ends, lying along its x axis."""

    kind = "capsule"

    def _build(
        self,
        name: str = "capsule",
        radius: float = 0.018,
        length: float = 0.06,
        mass: float = 0.06,
        friction: float = 1.0,
        rolling_friction: float = 5e-4,
        colour: Colour = (0.85, 0.66, 0.32),
    ) -> None:
        """Build the capsule.

        Args:
            name: Model name.
            radius: Radius [m].
            length: Length without the round ends [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            rolling_friction: Length of the lever arm of rolling friction [m].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(
            name, radius=radius, length=length, mass=mass, friction=friction,
            rolling_friction=rolling_friction, colour=colour,
        )  # fmt: skip
        self._half_height = positive("radius", radius, "m")
        length = positive("length", length, "m")
        rolling = positive("rolling_friction", rolling_friction, "m")
        geom = self._add("capsule", (radius, length / 2), euler=(0, np.pi / 2, 0))
        geom.condim = 6
        geom.friction = (friction, 0.005, rolling)
        self._weigh(mass)


# A truncated pyramid, 40 mm wide below, 34 mm above, and 40 mm high.
_WEIGHT = [
    [x, y, z]
    for z, half in ((-0.02, 0.02), (0.02, 0.017))
    for x in (-half, half)
    for y in (-half, half)
]


class ConvexMesh(Shape):
    """The convex hull of points, a truncated pyramid unless told otherwise."""

    kind = "mesh"

    def _build(
        self,
        name: str = "mesh",
        points: Sequence[Sequence[float]] = _WEIGHT,
        mass: float = 0.08,
        friction: float = 1.0,
        colour: Colour = (0.55, 0.57, 0.60),
    ) -> None:
        """Build the hull.

        Args:
            name: Model name.
            points: At least four points that are not in one plane, around the centre of mass; at
                rest it stands on the lowest. On the floor, which is a plane, MuJoCo makes four
                contacts at most: what stands on more corners trembles there [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        corners = np.array(points, dtype=float)
        flat = corners.ndim != 2 or corners.shape[1:] != (3,) or not np.isfinite(corners).all()
        if flat or np.linalg.matrix_rank(corners - corners.mean(axis=0), tol=1e-6) < 3:
            raise CellError("points are at least four places [m] that are not in one plane")
        self._begin(name, points=corners.tolist(), mass=mass, friction=friction, colour=colour)
        self._half_height = -float(corners[:, 2].min())
        mesh = self._mjcf_root.asset.add("mesh", name="hull", vertex=corners.ravel())
        self._mass = positive("mass", mass, "kg")
        self._body.add("geom", type="mesh", mesh=mesh, mass=self._mass, rgba=self._rgba)


class Block(Shape):
    """A wooden block; subclasses are of one colour each."""

    kind = "block"
    paint: ClassVar[tuple[float, float, float]] = (0.82, 0.68, 0.48)

    def _build(
        self,
        name: str | None = None,
        size: float = 0.04,
        mass: float = 0.045,
        friction: float = 1.0,
        colour: Sequence[float] | None = None,
    ) -> None:
        """Build the block.

        Args:
            name: Model name; default: its kind.
            size: Length of an edge [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1; default: its own.
        """
        colour = self.paint if colour is None else colour
        self._begin(name or self.kind, size=size, mass=mass, friction=friction, colour=colour)
        self._half_height = positive("size", size, "m") / 2
        self._add("box", (self._half_height,) * 3)
        self._weigh(mass)


class RedBlock(Block):
    """A red block."""

    kind = "red_block"
    paint = (0.78, 0.20, 0.18)


class GreenBlock(Block):
    """A green block."""

    kind = "green_block"
    paint = (0.26, 0.58, 0.30)


class BlueBlock(Block):
    """A blue block."""

    kind = "blue_block"
    paint = (0.20, 0.40, 0.72)


class YellowBlock(Block):
    """A yellow block."""

    kind = "yellow_block"
    paint = (0.92, 0.76, 0.22)
