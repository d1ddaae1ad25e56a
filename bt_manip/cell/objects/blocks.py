"""Blocks of several colours, to sort and to stack."""

from collections.abc import Sequence
from typing import ClassVar

from bt_manip.cell.objects.prop import positive
from bt_manip.cell.objects.shapes import Shape


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
