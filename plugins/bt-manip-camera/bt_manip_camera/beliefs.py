"""What a run believes of objects, beside the truth, for those who show it."""

from typing import Any

import numpy as np

from bt_manip.cell import Cell
from bt_manip.runner import Station
from bt_manip.spatial import quat_wxyz

from .detections import Detections
from .perception import centre_of, known_object
from .seen import SeenPoses

CORNERS = np.array([(x, y, z) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
EDGES = [
    (i, j)
    for i in range(8)
    for j in range(i + 1, 8)
    if np.count_nonzero(CORNERS[i] != CORNERS[j]) == 1
]
"""Numbers of the corners of each edge of a box."""

POINT_STEP = 4
"""One pixel of so many in both directions is a point of a depth image that is shown."""


def beliefs(station: Station) -> dict[str, dict[str, Any]]:
    """Return the beliefs about each expected object as plain data; empty without seen poses.

    Entries: ``position`` [m] and ``quat_wxyz`` where it is believed to be anywhere;
    ``true_position`` and ``true_quat_wxyz`` of the physics, and ``off``, the distance between both
    [m]; ``age`` [s], ``position_error`` [m] and ``camera`` of what was last seen of it.
    """
    believed, physics = station.believed, station.cell
    if believed is None or not isinstance(believed.poses.source, SeenPoses):
        return {}
    found: dict[str, dict[str, Any]] = {}
    for name in (one.name for one in believed.poses.source.expected):
        row = found[name] = {}
        for key, cell in (("", believed.cell), ("true_", physics)):
            if name in cell.entities:
                T_wo = cell.pose(name)
                row[f"{key}position"] = T_wo.translation.tolist()
                row[f"{key}quat_wxyz"] = quat_wxyz(T_wo).tolist()
        if {"position", "true_position"} <= row.keys():
            gap = np.subtract(row["position"], row["true_position"])
            row["off"] = float(np.linalg.norm(gap))
        seen = believed.poses.source.seen.get(name)
        if seen is not None:
            row |= {"age": physics.time - seen.time, "position_error": seen.position_error}
            row["camera"] = seen.camera
    return found


def edges(name: str, believed: Cell) -> np.ndarray:
    """Return the edges of the box around an object, in the frame of its origin [m]."""
    entity = believed.entities[name]
    known = known_object(name, entity)
    corners = CORNERS * known.size + centre_of(entity, known).translation
    return corners[EDGES]  # (12, 2, 3)


def latest_detections(station: Station) -> tuple[str, Detections | None]:
    """Return the camera and the detections of the latest frame that somebody used."""
    found = [
        (one.detections.frame.time, name, one.detections)
        for name, one in station.cell.entities.items()
        if getattr(one, "detections", None) is not None
    ]
    _, name, detections = max(found, key=lambda one: one[:2], default=(0.0, "", None))
    return name, detections
