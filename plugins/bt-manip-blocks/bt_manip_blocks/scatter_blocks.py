"""Scatter blocks on a table."""

import math
from typing import Any

import numpy as np

from bt_manip import spatial
from bt_manip.behaviours import poses_output
from bt_manip.bt import Action, Input, Output, Status
from bt_manip.cell import Cell, CellError, unique_name
from bt_manip_blocks.blocks import blocks_in
from bt_manip_blocks.coloured_block import ColouredBlock

ATTEMPTS = 2000


class ScatterBlocks(Action):
    """Clear all coloured blocks away, and scatter new ones with room for the fingers."""

    drawn = ("poses",)

    colours = Input(list[str], default=["red", "green", "blue"], doc="Colours, separated by ';'.")
    each = Input(int, default=1, doc="How many of each colour.")
    on = Input(str, default="table", doc="Name of the object whose surface they are put on.")
    region = Input(
        list[float],
        default=[0.2, 0.5, -0.35, 0.05],
        doc="Where their centres may come to lie, in the world: x_min;x_max;y_min;y_max [m].",
    )
    spacing = Input(float, default=0.08, doc="Least distance of two centres [m].")
    blocks = Output(list[str], doc="Names of the blocks.")
    poses = poses_output("Their poses in the world, each x;y;z;qw;qx;qy;qz [m], separated by '|'.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell and its randomness."""
        self.cell: Cell = infrastructure["cell"]
        self.rng: np.random.Generator = infrastructure["rng"]
        self._made: dict[tuple[str, int, int], ColouredBlock] = {}

    def initialise(self) -> None:
        """Scatter."""
        try:
            self._scatter()
        except CellError as error:
            self.fail(str(error))

    def update(self) -> Status:
        """Succeed: they are there."""
        return Status.SUCCESS

    def _scatter(self) -> None:
        cell = self.cell
        height = cell.surface_height(self.on)
        colours = self.colours
        wanted = [(colour, i, j) for i in range(self.each) for j, colour in enumerate(colours)]
        places = self._places(len(wanted))
        names, poses = [], []
        with cell.editing():
            for name in blocks_in(cell):
                cell.remove(name)
        blocks = [self._block(*key) for key in wanted]
        with cell.editing():  # another one: what comes by a name that goes would take its state
            for block, (x, y) in zip(blocks, places, strict=True):
                yaw = self.rng.uniform(-math.pi, math.pi)
                T_wo = spatial.pose(
                    (x, y, height + block.rest_height),
                    (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)),
                )
                name = unique_name(block.colour, cell.entities)
                names.append(cell.add(block, T_wo, name=name))
                poses.append(T_wo)
        self.blocks, self.poses = names, poses
        self.feedback_message = f"{len(names)} blocks"

    def _block(self, colour: str, i: int, j: int) -> ColouredBlock:
        """Return the block that was scattered before, or a new one: the same need no compile."""
        key = colour, i, j
        made = self._made.get(key)
        if made is None or not self.cell.is_reusable(made):
            made = self._made[key] = ColouredBlock(colour=colour)
        return made

    def _places(self, count: int) -> list[tuple[float, float]]:
        """Draw places that keep their distance.

        Raises:
            CellError: When the region is none or too small.
        """
        region = self.region
        if len(region) != 4 or region[0] > region[1] or region[2] > region[3]:
            raise CellError(f"a region is x_min;x_max;y_min;y_max [m], got {region}")
        x_min, x_max, y_min, y_max = region
        places: list[tuple[float, float]] = []
        for _ in range(ATTEMPTS):
            if len(places) == count:
                return places
            x, y = self.rng.uniform(x_min, x_max), self.rng.uniform(y_min, y_max)
            if all(math.hypot(x - a, y - b) >= self.spacing for a, b in places):
                places.append((x, y))
        raise CellError(
            f"{count} blocks find no room in {region} with {self.spacing:g} m between them"
        )
