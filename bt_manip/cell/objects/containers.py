"""Bin and tray; the origin is the middle of the bottom."""

from collections.abc import Sequence

from .primitive_prop import PrimitiveProp, lengths
from .prop import positive


class OpenBox(PrimitiveProp):
    """A bottom and four walls."""

    category = "container"

    def _box(self, size: Sequence[float], wall: float) -> None:
        x, y, z = lengths("size", size)
        wall = positive("wall", wall, "m")
        self._add("box", (x / 2, y / 2, wall / 2), (0, 0, wall / 2), name="floor")
        high, middle = (z - wall) / 2, (z + wall) / 2
        for sign in (1, -1):
            self._add("box", (wall / 2, y / 2, high), (sign * (x - wall) / 2, 0, middle))
            self._add("box", (x / 2 - wall, wall / 2, high), (0, sign * (y - wall) / 2, middle))


class Bin(OpenBox):
    """A deep box to throw things into."""

    kind = "bin"

    def _build(
        self,
        name: str = "bin",
        size: Sequence[float] = (0.30, 0.22, 0.16),
        wall: float = 0.008,
        mass: float = 0.8,
        friction: float = 0.6,
        colour: Sequence[float] = (0.25, 0.42, 0.55),
    ) -> None:
        """Build the bin.

        Args:
            name: Model name.
            size: Outer lengths along x, y and z [m].
            wall: Thickness of walls and bottom [m].
            mass: Mass, which counts where the bin is placed free [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, size=size, wall=wall, mass=mass, friction=friction, colour=colour)
        self._box(size, wall)
        self._weigh(mass)


class Tray(OpenBox):
    """A shallow box to set things down in."""

    kind = "tray"

    def _build(
        self,
        name: str = "tray",
        size: Sequence[float] = (0.34, 0.24, 0.03),
        wall: float = 0.006,
        mass: float = 0.4,
        friction: float = 0.6,
        colour: Sequence[float] = (0.62, 0.62, 0.60),
    ) -> None:
        """Build the tray.

        Args:
            name: Model name.
            size: Outer lengths along x, y and z [m].
            wall: Thickness of rim and bottom [m].
            mass: Mass, which counts where the tray is placed free [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, size=size, wall=wall, mass=mass, friction=friction, colour=colour)
        self._surface = wall
        self._box(size, wall)
        self._weigh(mass)

    @property
    def surface_height(self) -> float:
        """Height of its floor above the origin [m]."""
        return self._surface
