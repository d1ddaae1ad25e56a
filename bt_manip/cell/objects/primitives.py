"""Objects of primitive shapes; by default the origin is the centre of the bottom."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from bt_manip.parameters import Parameter
from bt_manip.spatial import as_numbers

from ..exceptions import CellError
from .primitive_prop import PrimitiveProp, length

GRASP_CENTRE_DEPTH = 0.03
"""Depth of the grasp centre below the top of objects taller than the fingers are long [m]."""

MAX_BOARDS = 100
"""Maximum number of a shelf's boards; each is a geom to compile."""

# Convex shapes


class Shape(PrimitiveProp):
    """A convex body that moves freely; its origin is its centre."""

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
        return np.array([0.0, 0.0, max(0.0, self._half_height - GRASP_CENTRE_DEPTH)])

    def _add_rolling(
        self, type: str, size: Sequence[float], rolling_friction: float, **pose: Any
    ) -> None:
        """Add a shape with a lever arm of rolling friction [m]."""
        self._half_height = size[0]
        geom = self._add(type, size, **pose)
        geom.condim = 6  # required for rolling friction
        geom.friction = (self._parameters["friction"], 0.005, rolling_friction)


class Box(Shape):
    """A box."""

    kind = "box"
    defaults = {
        "size": length("Lengths along x, y and z", (0.06, 0.04, 0.04)),
        "mass": 0.1, "friction": 1.0, "colour": (0.72, 0.53, 0.33),
    }  # fmt: skip

    def _add_shapes(self, size: Sequence[float]) -> None:
        x, y, z = size
        self._half_height = z / 2
        self._add("box", (x / 2, y / 2, z / 2))


class Cylinder(Shape):
    """An upright cylinder."""

    kind = "cylinder"
    defaults = {
        "radius": length("Radius", 0.02),
        "height": length("Height", 0.05),
        "mass": 0.1, "friction": 1.0, "colour": (0.42, 0.56, 0.68),
    }  # fmt: skip

    def _add_shapes(self, radius: float, height: float) -> None:
        self._half_height = height / 2
        self._add("cylinder", (radius, height / 2))


class Sphere(Shape):
    """A ball; rolling friction stops it."""

    kind = "sphere"
    defaults = {
        "radius": length("Radius", 0.025),
        "mass": 0.05, "friction": 1.0,
        "rolling_friction": length("Lever arm of rolling friction", 5e-4),
        "colour": (0.80, 0.36, 0.30),
    }  # fmt: skip

    def _add_shapes(self, radius: float, rolling_friction: float) -> None:
        self._add_rolling("sphere", (radius,), rolling_friction)


class Capsule(Shape):
    """A cylinder with round ends, lying along its x axis."""

    kind = "capsule"
    defaults = {
        "radius": length("Radius", 0.018),
        "length": length("Length without the round ends", 0.06),
        "mass": 0.06, "friction": 1.0,
        "rolling_friction": length("Lever arm of rolling friction", 5e-4),
        "colour": (0.85, 0.66, 0.32),
    }  # fmt: skip

    def _add_shapes(self, radius: float, length: float, rolling_friction: float) -> None:
        size, along_x = (radius, length / 2), (0, np.pi / 2, 0)
        self._add_rolling("capsule", size, rolling_friction, euler=along_x)


class ConvexMesh(Shape):
    """The convex hull of points, by default a truncated pyramid.

    It needs at least four points that are not in one plane, around the centre of mass; at rest it
    stands on the lowest points. On planes such as the floor, MuJoCo creates at most four contacts,
    so that an object with more corners at its bottom trembles.
    """

    kind = "mesh"
    defaults = {
        "points": Parameter(
            "Points; by default of a pyramid 40 mm wide at its bottom, 34 mm at its top, and 40 mm "
            "high", "m",
            [[x, y, z] for z, half in ((-0.02, 0.02), (0.02, 0.017))
             for x in (-half, half) for y in (-half, half)],
        ),
        "mass": 0.08, "friction": 1.0, "colour": (0.55, 0.57, 0.60),
    }  # fmt: skip

    def _add_shapes(self, points: Sequence[Sequence[float]]) -> None:
        corners = as_numbers(points)
        wrong = corners.shape[1:] != (3,) or not np.isfinite(corners).all()
        if wrong or np.linalg.matrix_rank(corners - corners.mean(axis=0), tol=1e-6) < 3:
            raise CellError("points must be at least four points [m] that are not in one plane")
        self._half_height = -float(corners[:, 2].min())
        mesh = self._mjcf_root.asset.add("mesh", name="hull", vertex=corners.ravel())
        self._body.add("geom", type="mesh", mesh=mesh, rgba=self._rgba)


class Block(Shape):
    """A wooden block; subclasses have one colour each."""

    kind = "block"
    defaults = {
        "size": length("Length of an edge", 0.04),
        "mass": 0.045, "friction": 1.0, "colour": (0.82, 0.68, 0.48),
    }  # fmt: skip

    def _add_shapes(self, size: float) -> None:
        self._half_height = size / 2
        self._add("box", (size / 2,) * 3)


class RedBlock(Block):
    """A red block."""

    kind = "red_block"
    defaults = {**Block.defaults, "colour": (0.78, 0.20, 0.18)}


class GreenBlock(Block):
    """A green block."""

    kind = "green_block"
    defaults = {**Block.defaults, "colour": (0.26, 0.58, 0.30)}


class BlueBlock(Block):
    """A blue block."""

    kind = "blue_block"
    defaults = {**Block.defaults, "colour": (0.20, 0.40, 0.72)}


class YellowBlock(Block):
    """A yellow block."""

    kind = "yellow_block"
    defaults = {**Block.defaults, "colour": (0.92, 0.76, 0.22)}


# Vessels


class Vessel(PrimitiveProp):
    """An upright object that moves freely."""

    category = "graspable"
    free = True

    @property
    def centre_offset(self) -> np.ndarray:
        """Grasp centre from above, in the object's frame [m]."""  # (3,)
        height = float(self._parameters["height"])
        return np.array([0.0, 0.0, max(height / 2, height - GRASP_CENTRE_DEPTH)])


class Can(Vessel):
    """A tin can."""

    kind = "can"
    defaults = {
        "radius": length("Radius", 0.033),
        "height": length("Height", 0.1),
        "mass": 0.2, "friction": 0.7, "colour": (0.72, 0.14, 0.16),
    }  # fmt: skip

    def _add_shapes(self, radius: float, height: float) -> None:
        self._add("cylinder", (radius, height / 2), (0, 0, height / 2))


class Bottle(Vessel):
    """A bottle with a neck to grip; belly, shoulder and neck are in proportion."""

    kind = "bottle"
    defaults = {
        "radius": length("Radius of the belly", 0.034),
        "height": length("Height", 0.2),
        "mass": 0.3, "friction": 0.8, "colour": (0.22, 0.46, 0.34, 0.9),
    }  # fmt: skip

    def _add_shapes(self, radius: float, height: float) -> None:
        belly, shoulder = 0.55 * height, 0.68 * height
        self._add("cylinder", (radius, belly / 2), (0, 0, belly / 2))
        for part in range(3):
            step = (shoulder - belly) / 3
            width = radius * (0.9 - 0.17 * part)
            self._add("cylinder", (width, step / 2), (0, 0, belly + (part + 0.5) * step))
        neck = height - shoulder
        self._add("cylinder", (0.45 * radius, neck / 2), (0, 0, shoulder + neck / 2))


class Mug(Vessel):
    """A hollow mug with a handle along x."""

    kind = "mug"
    defaults = {
        "radius": length("Outer radius", 0.032),
        "height": length("Height", 0.085),
        "wall": length("Thickness of wall and bottom", 0.004),
        "mass": 0.2, "friction": 0.7, "colour": (0.90, 0.89, 0.84),
    }  # fmt: skip

    def _add_shapes(self, radius: float, height: float, wall: float) -> None:
        inner = radius - wall
        self._add("cylinder", (inner, wall / 2), (0, 0, wall / 2))
        self._add_ring(inner, wall, height)
        out, grip = radius + 0.022, 0.0045
        for z in (0.25 * height, 0.75 * height):
            self._add("box", (0.012, grip, grip), (radius + 0.01, 0, z))
        self._add("box", (grip, grip, 0.25 * height + grip), (out, 0, height / 2))


# Containers and furniture


class Bin(PrimitiveProp):
    """A deep open box to drop objects into."""

    kind = "bin"
    category = "container"
    defaults = {
        "size": length("Outer lengths along x, y and z", (0.30, 0.22, 0.16)),
        "wall": length("Thickness of walls and bottom", 0.008),
        "mass": 0.8, "friction": 0.6, "colour": (0.25, 0.42, 0.55),
    }  # fmt: skip

    def _add_shapes(self, size: Sequence[float], wall: float) -> None:
        x, y, z = size
        self._add("box", (x / 2, y / 2, wall / 2), (0, 0, wall / 2), name="floor")
        high, middle = (z - wall) / 2, (z + wall) / 2
        for sign in (1, -1):
            self._add("box", (wall / 2, y / 2, high), (sign * (x - wall) / 2, 0, middle))
            self._add("box", (x / 2 - wall, wall / 2, high), (0, sign * (y - wall) / 2, middle))


class Tray(Bin):
    """A shallow open box to place objects in."""

    kind = "tray"
    defaults = {
        "size": length("Outer lengths along x, y and z", (0.34, 0.24, 0.03)),
        "wall": length("Thickness of rim and bottom", 0.006),
        "mass": 0.4, "friction": 0.6, "colour": (0.62, 0.62, 0.60),
    }  # fmt: skip

    @property
    def surface_height(self) -> float:
        """Height of its floor above the origin [m]."""
        return float(self._parameters["wall"])


class Shelf(PrimitiveProp):
    """A shelf, open in front, towards -x.

    Its boards are ``board_1`` (the lowest), ``board_2``, ...: ``PlaceOn`` accepts
    ``shelf/board_1``.
    """

    kind = "shelf"
    category = "surface"
    defaults = {
        "size": length("Outer lengths along x, y and z", (0.25, 0.6, 0.7)),
        "boards": Parameter("Number of boards, top and bottom included", "", 3, at_least=2,
                            at_most=MAX_BOARDS),
        "thickness": length("Thickness of all boards", 0.015),
        "mass": 6.0, "friction": 0.6, "colour": (0.76, 0.64, 0.48),
    }  # fmt: skip

    def _add_shapes(self, size: Sequence[float], boards: int, thickness: float) -> None:
        x, y, z = size
        half = thickness / 2
        inside = (y - 2 * thickness) / 2
        heights = [half + i * (z - thickness) / (boards - 1) for i in range(boards)]
        for i, height in enumerate(heights, 1):
            self._add("box", (x / 2, inside, half), (0, 0, height), name=f"board_{i}")
        for sign in (1, -1):
            self._add("box", (x / 2, half, z / 2), (0, sign * (y / 2 - half), z / 2))
        self._add("box", (half, inside, z / 2), (x / 2 - half, 0, z / 2))
        self.levels = tuple(height + half for height in heights)
        """Heights of the boards' top surfaces above the origin, the lowest first [m]."""

    @property
    def surface_height(self) -> float:
        """Height of the top above the origin [m]."""
        return self.levels[-1]


class Wall(PrimitiveProp):
    """A wall, as an obstacle."""

    kind = "wall"
    category = "obstacle"
    defaults = {
        "size": length("Lengths along x, y and z", (0.04, 0.4, 0.4)),
        "mass": 8.0, "friction": 0.6, "colour": (0.72, 0.70, 0.66),
    }  # fmt: skip

    def _add_shapes(self, size: Sequence[float]) -> None:
        x, y, z = size
        self._add("box", (x / 2, y / 2, z / 2), (0, 0, z / 2))
