"""What cameras see and what the tree believes, as messages of Foxglove's schemas."""

from collections.abc import Callable
from typing import Any

import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.CompressedImage_pb2 import CompressedImage
from foxglove_schemas_protobuf.ImageAnnotations_pb2 import ImageAnnotations
from foxglove_schemas_protobuf.LinePrimitive_pb2 import LinePrimitive
from foxglove_schemas_protobuf.PackedElementField_pb2 import PackedElementField
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.PointsAnnotation_pb2 import PointsAnnotation
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.timestamp_pb2 import Timestamp

from bt_manip.cell import WORLD
from bt_manip.runner import Run
from bt_manip_recording import jpeg, timestamp_of

from .beliefs import POINT_STEP, beliefs, edges
from .detections import Detections
from .frame import Frame

PERIOD = 0.1
"""Simulated time between two messages about what is believed [s]."""

NAMED, NAMELESS = Color(r=0.94, g=0.24, b=0.78, a=1.0), Color(r=0.16, g=0.2, b=0.27, a=1.0)
"""Colours of outlines of objects, and of things without a name."""


class SeenMessages:
    """Adds the frames that a run uses and what was detected in them, and believed poses.

    Topics: of each camera ``/seen/NAME/image``, ``outlines`` and ``points``; ``/believed``, data as
    of `beliefs`; ``/believed/outlines``, boxes in the scene.

    Args:
        run: The run.
        add: Adds a message to a topic of the recording, at the present time.
    """

    def __init__(self, run: Run, add: Callable[[str, Any], None]) -> None:
        self._station, self._add = run.station, add
        self._written: dict[str, Detections] = {}
        self._due = -np.inf

    def __call__(self) -> None:
        """Add what is new after a tick."""
        for name, one in self._station.cell.entities.items():
            new = getattr(one, "detections", None)
            if new is not None and new is not self._written.get(name):
                self._written[name] = new
                stamp, data = _stamp(new.frame.time), jpeg(new.frame.colour)
                image = CompressedImage(timestamp=stamp, frame_id=name, format="jpeg", data=data)
                self._add(f"/seen/{name}/image", image)
                self._add(f"/seen/{name}/outlines", annotations(new))
                self._add(f"/seen/{name}/points", cloud(new.frame))
        now = self._station.cell.time
        if now < self._due - 1e-6:
            return
        self._due = now + PERIOD
        if rows := beliefs(self._station):
            self._add("/believed", rows)
            self._add("/believed/outlines", self._boxes(rows))

    def _boxes(self, rows: dict[str, dict[str, Any]]) -> SceneUpdate:
        update, cell = SceneUpdate(), self._station.believed.cell  # type: ignore[union-attr]
        stamp = _stamp(self._station.cell.time)
        update.deletions.add(timestamp=stamp, type=SceneEntityDeletion.ALL)
        for name, row in rows.items():
            if "position" in row:
                box = update.entities.add(timestamp=stamp, frame_id=WORLD, id=name)
                line = box.lines.add(
                    type=LinePrimitive.LINE_LIST, thickness=2.0, scale_invariant=True, color=NAMED
                )
                T_wo = cell.pose(name)
                line.pose.orientation.w = 1.0
                ends = edges(name, cell).reshape(-1, 3) @ T_wo.rotation.T + T_wo.translation
                for x, y, z in ends:
                    line.points.add(x=x, y=y, z=z)
        return update


def annotations(detections: Detections) -> ImageAnnotations:
    """Return the outlines of what was detected, with labels."""
    message, stamp = ImageAnnotations(), _stamp(detections.frame.time)
    for one in detections.outlines():
        colour = NAMED if one.named else NAMELESS
        line = message.points.add(
            timestamp=stamp, type=PointsAnnotation.LINE_LOOP, outline_color=colour, thickness=2.0
        )
        for u, v in one.pixels:
            line.points.add(x=u, y=v)
        u, v = one.pixels.min(axis=0)
        text = message.texts.add(timestamp=stamp, text=one.label, font_size=16.0, text_color=colour)
        text.position.x, text.position.y = u, v - 4.0
    return message


def cloud(frame: Frame) -> PointCloud:
    """Return points of the depth image in the world, with their colours."""
    points, colours = frame.points(POINT_STEP)
    rows = np.zeros(len(points), [("xyz", "<f4", 3), ("rgb", "u1", 3), ("alpha", "u1")])
    rows["xyz"], rows["rgb"], rows["alpha"] = points, colours, 255
    message = PointCloud(
        timestamp=_stamp(frame.time), frame_id=WORLD, point_stride=rows.itemsize,
        data=rows.tobytes(),
    )  # fmt: skip
    message.pose.orientation.w = 1.0
    for i, name in enumerate("xyz"):
        message.fields.add(name=name, offset=4 * i, type=PackedElementField.FLOAT32)
    for i, name in enumerate(("red", "green", "blue", "alpha")):
        message.fields.add(name=name, offset=12 + i, type=PackedElementField.UINT8)
    return message


def _stamp(time: float) -> Timestamp:
    return timestamp_of(round(1e9 * time))
