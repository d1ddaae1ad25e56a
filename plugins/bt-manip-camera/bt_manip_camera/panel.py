"""Panel: where the tree believes objects, beside where they are."""

from html import escape
from typing import Any

import numpy as np

from bt_manip.cell import Cell
from bt_manip.runner import Run, Station
from bt_manip.spatial import quat_wxyz
from bt_manip_view import Panel

from .perception import centre_of, known_object
from .seen import SeenPoses

HEAD = ("believed", "position [mm]", "±", "off", "age [s]", "by")
"""The estimated standard deviation and the distance from the truth are in mm, too."""

COLOUR = (240, 60, 200)
"""Red, green and blue of the outlines."""

CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
EDGES = [
    (i, j)
    for i in range(8)
    for j in range(i + 1, 8)
    if np.count_nonzero(CORNERS[i] != CORNERS[j]) == 1
]
"""Numbers of the corners of each edge of a box."""


class SeenPanel(Panel):
    """Lists what `SeenPoses` has of each object, and draws outlines where the tree believes them.

    The scene shows the objects where the physics has them. Nothing is shown in runs without seen
    poses.

    Attributes:
        table: The rows of the objects, as HTML.
        outlines: The outlines in the scene, by object.
    """

    place = "left"
    needs_run = True

    def __init__(self, page: Any) -> None:
        self.table = page.gui.add("html", content="", visible=False)
        self._scene = page.server.scene
        self._believed: Any = None
        self.outlines: dict[str, Any] = {}

    def start(self, run: Run) -> None:
        """Show the objects of the run."""
        self.begin_idle(run.station)

    def begin_idle(self, station: Station) -> None:
        """Show the objects as they are between runs."""
        believed = station.believed
        seen = believed is not None and isinstance(believed.poses.source, SeenPoses)
        self._believed, self._physics = (believed if seen else None), station.cell
        self.table.visible = seen
        self._remove(list(self.outlines))

    def draw(self) -> None:
        """Send the table and the outlines."""
        if self._believed is None:
            return
        believed, source = self._believed.cell, self._believed.poses.source
        names = [one.name for one in source.expected]
        rows = [_row(name, believed, self._physics, source.seen.get(name)) for name in names]
        lines = ["".join(f"<th>{title}</th>" for title in HEAD)]
        lines += ["".join(f"<td>{escape(value)}</td>" for value in row) for row in rows]
        body = "".join(f"<tr>{line}</tr>" for line in lines)
        table = f'<table style="white-space:nowrap;font-size:smaller">{body}</table>'
        self.table.content = f'<div class="results">{table}</div>'
        self._remove([name for name in self.outlines if name not in believed.entities])
        for name in names:
            if name in believed.entities:
                self._outline(name, believed)

    def _outline(self, name: str, believed: Cell) -> None:
        """Draw an object, or move it to where it is believed."""
        if name not in self.outlines:
            entity = believed.entities[name]
            known = known_object(name, entity)
            corners = CORNERS * known.size + centre_of(entity, known).translation
            self.outlines[name] = self._scene.add_line_segments(
                f"/believed/{name}", corners[EDGES].astype(np.float32), COLOUR,
                thickness=2.0, thickness_units="screen",
            )  # fmt: skip
        T_wo, handle = believed.pose(name), self.outlines[name]
        handle.position, handle.wxyz = T_wo.translation, quat_wxyz(T_wo)

    def _remove(self, names: list[str]) -> None:
        for name in names:
            self.outlines.pop(name).remove()


def _row(name: str, believed: Cell, physics: Cell, seen: Any) -> list[str]:
    """Return the values of `HEAD`; ``-`` for those that there are not."""
    at = error = off = age = camera = "-"
    if seen is not None:
        error, age = f"{1e3 * seen.position_error:.1f}", f"{physics.time - seen.time:.1f}"
        camera = seen.camera
    if name in believed.entities:
        place = believed.pose(name).translation
        at = " ".join(f"{1e3 * value:z.0f}" for value in place)
        if name in physics.entities:
            off = f"{1e3 * np.linalg.norm(place - physics.pose(name).translation):.1f}"
    return [name, at, error, off, age, camera]
