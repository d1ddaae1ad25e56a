"""Panel: what cameras see, and where the tree believes objects, beside where they are."""

import base64
from html import escape
from typing import Any

import numpy as np

from bt_manip.cell import Cell
from bt_manip.runner import Run, Station
from bt_manip.spatial import quat_wxyz
from bt_manip_recording import jpeg
from bt_manip_view import Panel

from .beliefs import POINT_STEP, beliefs, edges, latest_detections
from .detections import Detections

HEAD = ("believed", "position [mm]", "±", "off", "age [s]", "by")
"""The estimated standard deviation and the distance from the truth are in mm, too."""

COLOUR, GREY = (240, 60, 200), (40, 50, 70)
"""Red, green and blue of the outlines of objects, and of things without a name."""

POINT_SIZE = 0.002
"""Size of a point of the depth image in the scene [m]."""


class SeenPanel(Panel):
    """Shows the last used picture with what was detected, and what `SeenPoses` has of each object.

    The scene shows the objects where the physics has them, and outlines where the tree believes
    them. Nothing is shown before something was seen.

    Attributes:
        picture: The picture, as HTML.
        points: Whether the points of the depth image are shown, a checkbox.
        table: The rows of the objects, as HTML.
        outlines: The outlines in the scene, by object.
        cloud: The points in the scene.
    """

    place = "left"
    needs_run = True

    def __init__(self, page: Any) -> None:
        self.picture = page.gui.add("html", content="", visible=False)
        hint = "Shows the points of the depth image in the scene"
        self.points = page.gui.add_checkbox("Depth", True, hint=hint)
        self.table = page.gui.add("html", content="", visible=False)
        self._scene = page.server.scene
        self._station: Any = None
        self._shown: Detections | None = None
        self.outlines: dict[str, Any] = {}
        self.cloud: Any = None
        self._hide()

    def start(self, run: Run) -> None:
        """Show the objects of the run."""
        self.begin_idle(run.station)

    def begin_idle(self, station: Station) -> None:
        """Show the objects as they are between runs."""
        self._station = station
        self._hide()

    def _hide(self) -> None:
        self._shown = None
        self.picture.visible = self.points.visible = self.table.visible = False
        self._remove(list(self.outlines))
        self._remove_cloud()

    def draw(self) -> None:
        """Send picture, points, table and outlines."""
        if self._station is None:
            return
        camera, detections = latest_detections(self._station)
        if detections is not None and detections is not self._shown:
            self._shown = detections
            self.picture.content, self.picture.visible = picture(camera, detections), True
            self.points.visible = True
            self._remove_cloud()
        if self._shown is not None and self.points.value != (self.cloud is not None):
            self._remove_cloud()
            if self.points.value:
                points, colours = self._shown.frame.points(POINT_STEP)
                self.cloud = self._scene.add_point_cloud(
                    "/seen", points.astype(np.float32), colours,
                    point_size=POINT_SIZE, precision="float32", point_shading="flat",
                )  # fmt: skip
        self._draw_beliefs()

    def _draw_beliefs(self) -> None:
        rows = beliefs(self._station)
        self.table.visible = bool(rows)
        lines = ["".join(f"<th>{title}</th>" for title in HEAD)]
        for name, row in rows.items():
            lines.append("".join(f"<td>{escape(value)}</td>" for value in _values(name, row)))
        body = "".join(f"<tr>{line}</tr>" for line in lines)
        table = f'<table style="white-space:nowrap;font-size:smaller">{body}</table>'
        self.table.content = f'<div class="results">{table}</div>'
        known = [name for name, row in rows.items() if "position" in row]
        self._remove([name for name in self.outlines if name not in known])
        for name in known:
            self._outline(name, self._station.believed.cell)

    def _outline(self, name: str, believed: Cell) -> None:
        """Draw an object, or move it to where it is believed."""
        if name not in self.outlines:
            self.outlines[name] = self._scene.add_line_segments(
                f"/believed/{name}", edges(name, believed).astype(np.float32), COLOUR,
                thickness=2.0, thickness_units="screen",
            )  # fmt: skip
        T_wo, handle = believed.pose(name), self.outlines[name]
        handle.position, handle.wxyz = T_wo.translation, quat_wxyz(T_wo)

    def _remove(self, names: list[str]) -> None:
        for name in names:
            self.outlines.pop(name).remove()

    def _remove_cloud(self) -> None:
        if self.cloud is not None:
            self.cloud.remove()
            self.cloud = None


def picture(camera: str, detections: Detections) -> str:
    """Return the picture of a camera with outlines of what was detected, as HTML."""
    frame, shapes = detections.frame, []
    height, width = frame.depth.shape
    for one in detections.outlines():
        colour = f"rgb{COLOUR if one.named else GREY}"
        corners = " ".join(f"{u:.1f},{v:.1f}" for u, v in one.pixels)
        u, v = one.pixels.min(axis=0)
        shapes += [
            f'<polygon points="{corners}" stroke="{colour}"/>'
            f'<text x="{u:.1f}" y="{v - 4.0:.1f}" fill="{colour}">{escape(one.label)}</text>'
        ]
    data = base64.b64encode(jpeg(frame.colour)).decode()
    return (
        f'<svg class="seen" viewBox="0 0 {width} {height}" style="width:100%" fill="none" '
        f'stroke-width="{width / 250:g}" font-size="{width / 30:g}">'
        f'<image href="data:image/jpeg;base64,{data}" width="{width}" height="{height}"/>'
        f'{"".join(shapes)}</svg><div class="note">{escape(camera)}, {frame.time:.2f} s</div>'
    )


def _values(name: str, row: dict[str, Any]) -> list[str]:
    """Return the values of `HEAD`; ``-`` for those that there are not."""
    at = error = off = age = "-"
    if "age" in row:
        error, age = f"{1e3 * row['position_error']:.1f}", f"{row['age']:.1f}"
    if "position" in row:
        at = " ".join(f"{1e3 * value:z.0f}" for value in row["position"])
    if "off" in row:
        off = f"{1e3 * row['off']:.1f}"
    return [name, at, error, off, age, row.get("camera", "-")]
