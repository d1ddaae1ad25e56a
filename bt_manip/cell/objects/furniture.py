"""Shelf and wall; the origin is the middle of the bottom."""

from collections.abc import Sequence

from ..exceptions import CellError
from .primitive_prop import PrimitiveProp, lengths
from .prop import positive


class Shelf(PrimitiveProp):
    """A shelf that is open in front, which is towards -x."""

    kind = "shelf"
    category = "surface"

    def _build(
        self,
        name: str = "shelf",
        size: Sequence[float] = (0.25, 0.6, 0.7),
        boards: int = 3,
        thickness: float = 0.015,
        mass: float = 6.0,
        friction: float = 0.6,
        colour: Sequence[float] = (0.76, 0.64, 0.48),
    ) -> None:
        """Build the shelf.

        Args:
            name: Model name.
            size: Outer lengths along x, y and z [m].
            boards: How many boards there are, top and bottom included.
            thickness: Of all boards [m].
            mass: Mass, which counts where the shelf is placed free [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.

        Raises:
            CellError: If there are fewer than two boards.
        """
        self._begin(
            name, size=size, boards=boards, thickness=thickness, mass=mass, friction=friction,
            colour=colour,
        )  # fmt: skip
        x, y, z = lengths("size", size)
        half = positive("thickness", thickness, "m") / 2
        if boards < 2:
            raise CellError(f"a shelf has at least 2 boards, got {boards}")
        inside = (y - 2 * thickness) / 2
        heights = [half + i * (z - thickness) / (boards - 1) for i in range(boards)]
        for height in heights:
            self._add("box", (x / 2, inside, half), (0, 0, height))
        for sign in (1, -1):
            self._add("box", (x / 2, half, z / 2), (0, sign * (y / 2 - half), z / 2))
        self._add("box", (half, inside, z / 2), (x / 2 - half, 0, z / 2))
        self._weigh(mass)
        self._levels = tuple(height + half for height in heights)

    @property
    def levels(self) -> tuple[float, ...]:
        """Heights of the boards' upper sides above the origin, the lowest first [m]."""
        return self._levels

    @property
    def surface_height(self) -> float:
        """Height of the top above the origin [m]."""
        return self._levels[-1]


class Wall(PrimitiveProp):
    """A wall to move around."""

    kind = "wall"
    category = "obstacle"

    def _build(
        self,
        name: str = "wall",
        size: Sequence[float] = (0.04, 0.4, 0.4),
        mass: float = 8.0,
        friction: float = 0.6,
        colour: Sequence[float] = (0.72, 0.70, 0.66),
    ) -> None:
        """Build the wall.

        Args:
            name: Model name.
            size: Lengths along x, y and z [m].
            mass: Mass, which counts where the wall is placed free [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, size=size, mass=mass, friction=friction, colour=colour)
        x, y, z = lengths("size", size)
        self._add("box", (x / 2, y / 2, z / 2), (0, 0, z / 2))
        self._weigh(mass)
