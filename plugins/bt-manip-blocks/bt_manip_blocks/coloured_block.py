"""A block of a colour."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from dm_control import composer, mjcf

from bt_manip.cell import CellError
from bt_manip.exceptions import did_you_mean

COLOURS: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {
        "red": (0.78, 0.20, 0.18),
        "green": (0.26, 0.58, 0.30),
        "blue": (0.20, 0.40, 0.72),
        "yellow": (0.92, 0.76, 0.22),
        "orange": (0.90, 0.49, 0.13),
        "violet": (0.48, 0.32, 0.64),
    }
)
"""Red, green and blue of each colour, from 0 to 1."""

DENSITY = 700.0  # [kg/m3] beech


class ColouredBlock(composer.Entity):
    """A wooden cube, painted; its origin is its centre."""

    kind = "coloured_block"
    category = "graspable"
    free = True

    def _build(self, name: str | None = None, colour: str = "red", size: float = 0.04) -> None:
        """Build the block.

        Args:
            name: Model name; default: its colour.
            colour: One of `COLOURS`.
            size: Length of an edge [m].

        Raises:
            CellError: When there is no such colour, or no such size.
        """
        if colour not in COLOURS:
            raise CellError(f"no colour '{colour}'{did_you_mean(colour, COLOURS)}")
        if not 0.0 < size < np.inf:
            raise CellError(f"size must be a positive number [m], got {size!r}")
        self.colour, self.size = colour, size
        self._mjcf_root = root = mjcf.RootElement(model=name or colour)
        body = root.worldbody.add("body", name="block")
        body.add(
            "geom", name="block", type="box", size=[size / 2] * 3, mass=DENSITY * size**3,
            friction=(0.8, 0.005, 0.0001), solref=(0.004, 1), rgba=(*COLOURS[colour], 1),
        )  # fmt: skip

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """The model that composer attaches."""
        return self._mjcf_root

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Its parameters, as plain data."""
        return MappingProxyType({"colour": self.colour, "size": self.size})

    @property
    def rest_height(self) -> float:
        """Height of the centre above its support [m]."""
        return self.size / 2
