"""A tray with a row for each colour."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import CellError, ParametricEntity
from bt_manip.exceptions import did_you_mean
from bt_manip.parameters import Parameter
from bt_manip.spatial import pointing_down
from bt_manip_blocks.coloured_block import COLOURS

FLOOR = 0.005  # [m] thickness
RIM = 0.012  # [m] height over the floor
WALL = 0.005  # [m] thickness
ROW = 0.085  # [m] spacing of rows: the open fingers extend 55 mm to either side of a block
BLOCK = 0.03  # [m] height of the tool over a slot's bottom when placing a block
SLOT = 0.06  # [m] spacing of slots


class SortingTray(ParametricEntity):
    """A flat tray with a row for each colour; its origin is the centre of its bottom.

    Rows are along its x axis; the first colour has the row with the largest y.
    """

    kind = "sorting_tray"
    category = "tray"
    free = False
    defaults = {
        "colours": Parameter("Colours of the rows", default=["red", "green", "blue"]),
        "slots": Parameter("Number of blocks in a row", default=3, at_least=1),
    }

    def _make_model(self, name: str) -> None:
        self.colours = colours = tuple(self._parameters["colours"])
        self.slots = int(self._parameters["slots"])
        for colour in colours:
            if colour not in COLOURS:
                raise CellError(f"no colour '{colour}'{did_you_mean(colour, COLOURS)}")
        if not colours or len(set(colours)) < len(colours):
            raise CellError(f"a tray has one row for each of its colours, got {colours}")
        self._mjcf_root = root = mjcf.RootElement(model=name)
        body = root.worldbody.add("body", name="tray")
        x, y = self.slots * SLOT / 2, len(self.colours) * ROW / 2

        def add(label: str, size: Sequence[float], pos: Sequence[float], rgb: Any) -> None:
            body.add(
                "geom", name=label, type="box", size=size, pos=pos, rgba=(*rgb, 1), mass=0.05,
                friction=(0.8, 0.005, 0.0001), solref=(0.004, 1),
            )  # fmt: skip

        for colour in self.colours:
            middle = self._row(colour)
            pale = 0.5 + 0.5 * np.array(COLOURS[colour])
            add(f"floor_{colour}", (x, ROW / 2, FLOOR / 2), (0, middle, FLOOR / 2), pale)
        grey, height = (0.35, 0.35, 0.37), (FLOOR + RIM) / 2
        for i, side in (("left", 1), ("right", -1)):
            at = side * (y + WALL / 2)
            add(f"wall_{i}", (x + WALL, WALL / 2, height), (0, at, height), grey)
        for i, side in (("front", 1), ("back", -1)):
            at = side * (x + WALL / 2)
            add(f"wall_{i}", (WALL / 2, y, height), (at, 0, height), grey)

    @property
    def tool_targets(self) -> list[list[pin.SE3]]:
        """Poses of the tool at blocks in the corners of the tray, and over them."""
        places = [
            slot for colour in (self.colours[0], self.colours[-1]) for slot in self.row(colour)
        ]
        return [
            [pointing_down(slot.translation + (0.0, 0.0, z), k * np.pi / 4) for k in range(4)]
            for slot in (places[0], places[self.slots - 1], places[-self.slots], places[-1])
            for z in (BLOCK, BLOCK + 0.1)
        ]

    def row(self, colour: str) -> list[pin.SE3]:
        """List the slots of a colour: positions of blocks' bottoms in the tray's frame.

        Raises:
            CellError: If the tray has no row of this colour.
        """
        if colour not in self.colours:
            raise CellError(
                f"the tray has no row for '{colour}'{did_you_mean(colour, self.colours)}"
            )
        first = -0.5 * (self.slots - 1) * SLOT
        return [
            pin.SE3(np.eye(3), np.array([first + i * SLOT, self._row(colour), FLOOR]))
            for i in range(self.slots)
        ]

    def row_at(self, position: np.ndarray) -> str | None:
        """Return the colour of the row under a position in the tray's frame; None elsewhere."""
        if position[2] < 0.0 or abs(position[0]) > self.slots * SLOT / 2:
            return None
        for colour in self.colours:
            if abs(position[1] - self._row(colour)) <= ROW / 2:
                return colour
        return None

    def row_box(self, colour: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of a row in the tray's frame [m]."""  # 2 x (1, 3)
        x, y = self.slots * SLOT / 2, self._row(colour)
        lower, upper = [-x, y - ROW / 2, FLOOR], [x, y + ROW / 2, FLOOR + RIM]
        return np.array([lower]), np.array([upper])

    def _row(self, colour: str) -> float:
        """Return the y of a row's centre line [m]."""
        return (0.5 * (len(self.colours) - 1) - self.colours.index(colour)) * ROW
