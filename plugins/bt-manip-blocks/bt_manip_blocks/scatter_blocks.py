"""Scattering of blocks on a table."""

import math
from dataclasses import replace
from typing import Any

import numpy as np

from bt_manip import spatial
from bt_manip.behaviours import CellBehaviour, numbers_or_auto, poses_output
from bt_manip.bt import Input, Output, Status, Traits
from bt_manip.cell import CellError, Region, extent, unique_name
from bt_manip_blocks.blocks import blocks_in
from bt_manip_blocks.coloured_block import ColouredBlock

ATTEMPTS = 2000
FINGERS = 0.11  # [m] from a block's centre to fixed objects: clearance of the fingers at any yaw
_NO_YAW = (0.0, 0.0)  # [rad]; sampled separately


class ScatterBlocks(CellBehaviour):
    """Remove all coloured blocks, and scatter new ones with clearance for the fingers.

    With seen poses (``--poses seen``) they lie in the physics, and the tree knows where one lies
    once it has seen it.
    """

    traits = Traits()
    drawn = ("poses",)

    colours = Input(list[str], default=["red", "green", "blue"], doc="Colours, separated by ';'.")
    each = Input(int, default=1, doc="Number of blocks of each colour.")
    on = Input(str, default="table", doc="Name of the supporting object.")
    region = numbers_or_auto(
        "Region of their centres in the world: x_min;x_max;y_min;y_max [m]; auto: the preferred "
        "region, or the part of the surface that the robot reaches from above, beside all fixed "
        "objects.",
    )
    preferred_region = Input(
        list[float],
        default=[0.2, 0.5, -0.35, 0.05],
        doc="Preferred region for auto, if the robot reaches all of it.",
    )
    spacing = Input(float, default=0.08, doc="Smallest distance of two centres [m].")
    blocks = Output(list[str], doc="Names of the blocks.")
    poses = poses_output("Their poses in the world, each x;y;z;qw;qx;qy;qz [m], separated by '|'.")

    adds_objects = ("*",)

    def setup(self, **infrastructure: Any) -> None:
        """Store the random generator and the robots, too."""
        super().setup(**infrastructure)
        self.rng: np.random.Generator = infrastructure["rng"]
        self._robots = infrastructure["robots"]
        self._made: dict[tuple[str, int, int], ColouredBlock] = {}

    def start(self) -> None:
        """Scatter."""
        cell = self.physics
        height = cell.surface_height(self.on)
        colours = self.colours
        wanted = [(colour, i, j) for i in range(self.each) for j, colour in enumerate(colours)]
        names, poses = [], []
        with self.cell.editing():
            for name in blocks_in(self.cell):
                self.cell.remove(name)
        seen = self.expected if cell is not self.cell else None
        if seen is not None:
            with cell.editing():
                for name in blocks_in(cell):
                    seen.taken(name)
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
        if seen is not None:
            for name in names:
                seen.spawned(name)
        self.blocks, self.poses = names, poses
        self.feedback_message = f"{len(names)} blocks"

    def update(self) -> Status:
        """Succeed; the blocks are in the cell."""
        return Status.SUCCESS

    def _block(self, colour: str, i: int, j: int) -> ColouredBlock:
        """Return a block scattered before, or a new one; reused blocks need no compile."""
        key = colour, i, j
        made = self._made.get(key)
        if made is None or not self.physics.is_reusable(made):
            made = self._made[key] = ColouredBlock(colour=colour)
        return made

    def _places(self, count: int, height: float) -> list[tuple[float, float]]:
        """Sample positions of blocks whose centres are at a height over the surface [m]."""
        region = self._area(height)
        places: list[tuple[float, float]] = []
        for _ in range(ATTEMPTS):
            if len(places) == count:
                return places
            x, y, _ = region.sample(self.rng).translation
            if all(math.hypot(x - a, y - b) >= self.spacing for a, b in places):
                places.append((x, y))
        bounds = ", ".join(f"{bound:g}" for bound in (*region.x, *region.y))
        raise CellError(
            f"{count} blocks find no room in [{bounds}] with {self.spacing:g} m between them"
        )

    def _area(self, height: float) -> Region:
        """Return the region of the centres of blocks."""
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
            raise CellError(f"the robot reaches no position on '{self.on}' beside fixed objects")
        return replace(area, squares=tuple(squares), yaw=_NO_YAW)

    def _is_beside_others(self, place: tuple[float, float]) -> bool:
        """Return whether a block at a position has clearance to all fixed objects."""
        for name in self.cell.objects:
            if name != self.on and not self.cell.is_free(name):
                lower, upper = extent(self.cell, name)
                outside = np.maximum(lower[:2] - place, place - upper[:2])
                if outside.max() < FINGERS:
                    return False
        return True
