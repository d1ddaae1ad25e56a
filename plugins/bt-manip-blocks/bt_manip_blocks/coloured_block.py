"""A coloured block."""

from collections.abc import Mapping
from types import MappingProxyType

from dm_control import mjcf

from bt_manip.cell import CellError, ParametricEntity
from bt_manip.exceptions import did_you_mean
from bt_manip.parameters import Parameter

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


class ColouredBlock(ParametricEntity):
    """A painted wooden cube; its origin is its centre."""

    kind = "coloured_block"
    category = "graspable"
    free = True
    defaults = {
        "colour": Parameter(f"Colour: {', '.join(COLOURS)}", default="red"),
        "size": Parameter("Length of an edge", "m", 0.04, above=0.0),
    }

    def _make_model(self, name: str) -> None:
        self.colour, self.size = colour, size = self._parameters.values()
        if colour not in COLOURS:
            raise CellError(f"no colour '{colour}'{did_you_mean(colour, COLOURS)}")
        name = colour if name == self.kind else name
        self._mjcf_root = root = mjcf.RootElement(model=name)
        body = root.worldbody.add("body", name="block")
        body.add(
            "geom", name="block", type="box", size=[size / 2] * 3, mass=DENSITY * size**3,
            friction=(0.8, 0.005, 0.0001), solref=(0.004, 1), rgba=(*COLOURS[colour], 1),
        )  # fmt: skip

    @property
    def rest_height(self) -> float:
        """Height of the centre above its support [m]."""
        return self.size / 2
