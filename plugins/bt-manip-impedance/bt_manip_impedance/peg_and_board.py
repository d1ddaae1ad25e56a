"""A peg, and a board with a hole for it."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.cell import CellError
from bt_manip.cell.objects import PrimitiveProp, Shape, length
from bt_manip.parameters import Parameter
from bt_manip.spatial import pointing_down

HELD, INSERTED = 0.08, 0.03  # [m] height of the tool over a held peg's end; insertion depth


class Peg(Shape):
    """An upright round peg for a `HoleBoard`."""

    kind = "peg"
    defaults = {
        "radius": length("Radius", 0.015),
        "length": length("Length", 0.09),
        "mass": 0.08, "friction": 0.6, "colour": (0.83, 0.55, 0.25),
    }  # fmt: skip

    def _add_shapes(self, radius: float, length: float) -> None:
        self._half_height = length / 2
        self._add("cylinder", (radius, length / 2))


class HoleBoard(PrimitiveProp):
    """A square board with a hole: a polygon of 16 sides around a circle.

    The hole is at the centre of the board, or displaced by an ``offset``: a manufacturing tolerance
    that the board's pose does not show.
    """

    kind = "hole_board"
    category = "socket"
    defaults = {
        "hole": length("Radius of the circle that fits into the hole", 0.0165),
        "size": length("Lengths along x, y and z", (0.16, 0.16, 0.04)),
        "offset": Parameter("Offset of the hole from the middle, along x and y", "m", (0.0, 0.0)),
        "mass": 0.9, "friction": 0.4, "colour": (0.50, 0.53, 0.58),
    }  # fmt: skip

    @property
    def tool_targets(self) -> list[list[pin.SE3]]:
        """Poses of the tool with the end of a peg in the hole, and above the board."""
        top = float(self._parameters["size"][2])
        return [
            [pointing_down((0.0, 0.0, top + z), k * np.pi / 4) for k in range(4)]
            for z in (HELD - INSERTED, HELD, HELD + 0.03)
        ]

    def _add_shapes(self, hole: float, size: Sequence[float], offset: Sequence[float]) -> None:
        x, y, z = size
        u, v = offset
        # The hole is a ring in a square opening of the board: the corners of the opening are inside
        # the ring's wall, its sides outside of the hole.
        thickness = 0.8 * hole
        opening = (hole + thickness) / 2**0.5
        if not min(x / 2 - abs(u), y / 2 - abs(v)) > opening:
            wide = 2 * (opening + max(abs(u), abs(v)))
            raise CellError(
                f"a hole of radius {hole:g} m at an offset of {u:g}, {v:g} m needs a board wider "
                f"than {wide:g} m"
            )
        self._add_ring(hole, thickness, z, centre=(u, v))
        for sign in (1, -1):
            side, end = (x / 2 - opening - sign * u) / 2, (y / 2 - opening - sign * v) / 2
            self._add("box", (side, y / 2, z / 2), (u + sign * (opening + side), 0, z / 2))
            self._add("box", (opening, end, z / 2), (u, v + sign * (opening + end), z / 2))
