"""Scatter blocks on a table."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from bt_manip import spatial
from bt_manip.behaviours import CellBehaviour, numbers_or_auto, poses_output
from bt_manip.bt import Input, Output, Status
from bt_manip.cell import CellError, Region, extent, unique_name
from bt_manip_blocks.blocks import blocks_in
from bt_manip_blocks.coloured_block import ColouredBlock

ATTEMPTS = 2000
FINGERS = 0.11  # [m] from a block's middle to fixed objects beside it: fingers have room at any yaw
_NO_YAW = (0.0, 0.0)  # [rad]: sampled apart


class ScatterBlocks(CellBehaviour):
    """Clear all coloured blocks away, and scatter new ones with room for the fingers."""

    drawn = ("poses",)

    colours = Input(list[str], default=["red", "green", "blue"], doc="Colours, separated by ';'.")
    each = Input(int, default=1, doc="How many of each colour.")
    on = Input(str, default="table", doc="Name of the object whose surface they are put on.")
    region = numbers_or_auto(
        "Where their centres may come to lie, in the world: x_min;x_max;y_min;y_max [m]; auto: the "
        "preferred region, or where the robot reaches the surface from above beside all else that "
        "is fixed on it.",
    )
    preferred_region = Input(
        list[float],
        default=[0.2, 0.5, -0.35, 0.05],
        doc="Region that auto takes if the robot reaches all of it.",
    )
    spacing = Input(float, default=0.08, doc="Least distance of two centres [m].")
    blocks = Output(list[str], doc="Names of the blocks.")
    poses = poses_output("Their poses in the world, each x;y;z;qw;qx;qy;qz [m], separated by '|'.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep randomness and robots too."""
        super().setup(**infrastructure)
        self.rng: np.random.Generator = infrastructure["rng"]
        self._robots = infrastructure["robots"]
        self._made: dict[tuple[str, int, int], ColouredBlock] = {}

    def start(self) -> None:
        """Scatter."""
        cell = self.cell
        height = cell.surface_height(self.on)
        colours = self.colours
        wanted = [(colour, i, j) for i in range(self.each) for j, colour in enumerate(colours)]
        names, poses = [], []
        with cell.editing():
            for name in blocks_in(cell):
                cell.remove(name)
        blocks = [self._block(*key) for key in wanted]
        places = self._places(len(wanted), blocks[0].rest_height)
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

    def update(self) -> Status:
        """Succeed: they are there."""
        return Status.SUCCESS

    def _block(self, colour: str, i: int, j: int) -> ColouredBlock:
        """Return the block that was scattered before, or a new one: the same need no compile."""
        key = colour, i, j
        made = self._made.get(key)
        if made is None or not self.cell.is_reusable(made):
            made = self._made[key] = ColouredBlock(colour=colour)
        return made

    def _places(self, count: int, height: float) -> list[tuple[float, float]]:
        """Draw places that keep their distance.

        Args:
            count: Number of places.
            height: Of the middle of a block over the surface [m].

        Raises:
            CellError: When the region is none or too small.
        """
        region = self._area(height)
        places: list[tuple[float, float]] = []
        for _ in range(ATTEMPTS):
            if len(places) == count:
                return places
            x, y, _ = region.sample(self.rng).translation
            if all(math.hypot(x - a, y - b) >= self.spacing for a, b in places):
                places.append((x, y))
        raise CellError(
            f"{count} blocks find no room in {_shown(region)} with {self.spacing:g} m between them"
        )

    def _area(self, height: float) -> Region:
        """Return where the centres of blocks may come to lie."""
        given, preferred = self.region, self.preferred_region
        for region in (preferred, *([] if given is None else [given])):
            if len(region) != 4 or region[0] > region[1] or region[2] > region[3]:
                raise CellError(f"a region is x_min;x_max;y_min;y_max [m], got {region}")
        x_min, x_max, y_min, y_max = preferred if given is None else given
        if given is not None:
            return Region((x_min, x_max), (y_min, y_max), (0.0, 0.0), _NO_YAW)
        reach = next(iter(self._robots.values())).reach
        area = reach.area(self.cell, self.on, height, (x_min, x_max, y_min, y_max))
        squares = [p for p in area.squares if self._is_beside_others(p)]
        if area.squares and not squares:
            raise CellError(f"the robot reaches no place on '{self.on}' beside all that is fixed")
        return replace(area, squares=tuple(squares), yaw=_NO_YAW)

    def _is_beside_others(self, place: tuple[float, float]) -> bool:
        """Return whether a block at a place has room beside all fixed objects."""
        for name in self.cell.objects:
            if name != self.on and not self.cell.is_free(name):
                lower, upper = extent(self.cell, name)
                outside = np.maximum(lower[:2] - place, place - upper[:2])
                if outside.max() < FINGERS:
                    return False
        return True


def _shown(region: Region) -> str:
    """Return a region as text."""
    (x_min, x_max), (y_min, y_max) = region.x, region.y
    return f"[{x_min:g}, {x_max:g}, {y_min:g}, {y_max:g}]"
