"""A peg, and the board with the hole that it goes into."""

from collections.abc import Sequence

from ..exceptions import CellError
from .primitive_prop import PrimitiveProp, lengths
from .prop import positive
from .shapes import Shape


class Peg(Shape):
    """A round peg that stands upright; its origin is its centre."""

    kind = "peg"

    def _build(
        self,
        name: str = "peg",
        radius: float = 0.015,
        length: float = 0.09,
        mass: float = 0.08,
        friction: float = 0.6,
        colour: Sequence[float] = (0.83, 0.55, 0.25),
    ) -> None:
        """Build the peg.

        Args:
            name: Model name.
            radius: Radius [m].
            length: Length [m].
            mass: Mass [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.
        """
        self._begin(name, radius=radius, length=length, mass=mass, friction=friction, colour=colour)
        radius, length = positive("radius", radius, "m"), positive("length", length, "m")
        self._half_height = length / 2
        self._add("cylinder", (radius, length / 2))
        self._weigh(mass)


class HoleBoard(PrimitiveProp):
    """A square board with a round hole through its middle; its origin is the middle of its bottom.

    The hole is a polygon of 16 sides around a circle.
    """

    kind = "hole_board"
    category = "socket"

    def _build(
        self,
        name: str = "hole_board",
        hole: float = 0.0165,
        size: Sequence[float] = (0.16, 0.16, 0.04),
        mass: float = 0.9,
        friction: float = 0.4,
        colour: Sequence[float] = (0.50, 0.53, 0.58),
    ) -> None:
        """Build the board.

        Args:
            name: Model name.
            hole: Radius of the circle that fits into the hole [m].
            size: Lengths along x, y and z [m].
            mass: Mass, which counts where the board is placed free [kg].
            friction: Coefficient of sliding friction [-].
            colour: Red, green, blue, and opacity where given, from 0 to 1.

        Raises:
            CellError: If the board is too narrow for its hole.
        """
        self._begin(name, hole=hole, size=size, mass=mass, friction=friction, colour=colour)
        x, y, z = lengths("size", size)
        hole = positive("hole", hole, "m")
        # A ring closes the hole to a square opening in the board around it: the corners of the
        # opening are inside the ring, its sides outside of the hole.
        thickness = 0.8 * hole
        opening = (hole + thickness) / 2**0.5
        if min(x, y) / 2 <= opening:
            raise CellError(f"a hole of radius {hole:g} m needs a board wider than {2 * opening:g}")
        self._ring(hole, thickness, z, 0.0)
        side, end = (x / 2 - opening) / 2, (y / 2 - opening) / 2
        for sign in (1, -1):
            self._add("box", (side, y / 2, z / 2), (sign * (opening + side), 0, z / 2))
            self._add("box", (opening, end, z / 2), (0, sign * (opening + end), z / 2))
        self._weigh(mass)
