"""Viewpoints of the browsers, which frame robots, objects and containers."""

import time
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
import trimesh

from bt_manip.cell import OVERVIEW, WORLD
from bt_manip.viewer import FREE_CAMERA
from bt_manip_recording import SceneSource, VisualShape

NOT_FRAMED = (WORLD, "table")
"""Entities that may extend beyond the image."""

FRAMED_SHARE = 0.86
"""Share of width and height to fill; the rest is margin for moving arms."""

FIRST_ASPECT = 1.4
"""Aspect ratio (width by height) until a browser reports its size."""

FOV = np.deg2rad(45.0)
"""Vertical field of view without a camera `OVERVIEW` [rad]."""

PERIOD = 1.0
"""Wall time between two checks of the visibility [s]."""

SAME = 1e-3
"""Largest difference of coordinates that count as equal [m]."""

MAX_FRAMED_POINTS = 20_000
"""Largest number of framed points, present and past."""


class Framing:
    """Places the camera of each browser, until its user moves it."""

    def __init__(self, server: Any) -> None:
        self._server = server
        self._points = np.empty((0, 3))
        self._axes, self._fov = np.eye(3), float(FOV)
        self._corners: dict[str, np.ndarray] = {}  # of the boxes around shapes, by body
        self._cameras: dict[int, _Camera] = {}  # by client
        self._own: deque[np.ndarray] = deque(maxlen=100)  # latest positions not set by a user
        self._next = 0.0
        server.on_client_connect(self._connected)
        server.on_client_disconnect(lambda client: self._cameras.pop(client.client_id, None))

    def show(
        self, source: SceneSource, entities: Mapping[str, Mapping[str, Sequence[VisualShape]]]
    ) -> None:
        """Frame all entities of a scene in its present state, by the shapes of their bodies."""
        shown = {n: bodies for n, bodies in entities.items() if n not in NOT_FRAMED} or entities
        self._corners = {
            body: np.concatenate([_corners(shape) for shape in shapes])
            for bodies in shown.values()
            for body, shapes in bodies.items()
            if shapes
        }
        self._points = self._now(source)
        self._axes, self._fov = _line_of_sight(source)
        first = self._server.initial_camera
        first.position, first.look_at = self._placed(FIRST_ASPECT)
        first.fov = self._fov
        self._own.append(np.array(first.position))  # viser may move a new client there, late
        self._bring_back(self._points)

    def update(self, source: SceneSource) -> None:
        """Move back cameras whose image some arm or object has left, at most once a second."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + PERIOD
            self._bring_back(self._now(source))

    # Internal

    def _now(self, source: SceneSource) -> np.ndarray:
        """Return the present corners of all boxes in the world [m]."""  # (n, 3)
        found = [
            rotated(pose[3:], self._corners[body]) + pose[:3]
            for body, pose in zip(source.frames, source.poses(), strict=True)
            if body in self._corners and np.isfinite(pose).all()  # it is in the scene now
        ]
        return np.concatenate([np.empty((0, 3)), *found])

    def _placed(self, aspect: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the nearest position that shows all points, and the point to look at [m].

        The distances of the points to the four planes of the view frustum are linear in the
        position: opposite planes give it sideways, the narrower pair gives its depth.
        """
        if not len(self._points):
            return np.ones(3), np.zeros(3)
        right, up, forward = (self._points @ self._axes).T
        depths, offsets = [], []
        for across, tangent in ((right, aspect), (up, 1.0)):
            slope = FRAMED_SHARE * np.tan(self._fov / 2.0) * tangent
            high, low = (across - slope * forward).max(), (-across - slope * forward).max()
            depths.append(-(high + low) / (2.0 * slope))
            offsets.append((high - low) / 2.0)
        depth = min(depths)
        position = self._axes @ [*offsets, depth]
        return position, position + (forward.mean() - depth) * self._axes[:, 2]

    def _bring_back(self, points: np.ndarray) -> None:
        """Move cameras that miss some of the points, so that they also show the earlier ones."""
        lost = [
            (client, camera)
            for client in self._server.get_clients().values()
            if (camera := self._cameras.get(client.client_id)) is not None
            and not (camera.moved or self._sees(points, camera.position, client.camera.aspect))
        ]
        if lost:
            self._points = np.concatenate([self._points, points])[-MAX_FRAMED_POINTS:]
        for client, camera in lost:
            self._place(client, camera)

    def _place(self, client: Any, camera: "_Camera") -> None:
        """Place the camera of a client, unless its user has moved it."""
        if camera.moved or not len(self._points):
            return
        position, look_at = self._placed(client.camera.aspect)
        camera.position = position
        self._own.append(position)
        with client.atomic():
            client.camera.fov = self._fov
            client.camera.position, client.camera.look_at = position, look_at

    def _sees(self, points: np.ndarray, position: np.ndarray, aspect: float) -> bool:
        right, up, forward = ((points - position) @ self._axes).T
        slope = np.tan(self._fov / 2.0) * forward
        return bool((abs(right) < slope * aspect).all() and (abs(up) < slope).all())

    def _connected(self, client: Any) -> None:
        camera = self._cameras[client.client_id] = _Camera(client.camera.position)
        self._own.append(camera.position)
        size = [client.camera.image_width, client.camera.image_height]

        @client.camera.on_update
        def _(_: Any) -> None:
            now = [client.camera.image_width, client.camera.image_height]
            position = client.camera.position
            camera.moved |= all(np.abs(position - own).max() > SAME for own in [*self._own])
            if size != now or np.abs(position - camera.position).max() > SAME:
                size[:] = now
                self._place(client, camera)

        self._place(client, camera)


@dataclass
class _Camera:
    """The camera of a client: its position when it was placed, and whether its user moved it."""

    position: np.ndarray
    moved: bool = False


def _line_of_sight(source: SceneSource) -> tuple[np.ndarray, float]:
    """Return the axes of the view as columns (right, up, forward), and its field of view [rad]."""
    for camera in source.cameras:
        if camera.name == OVERVIEW:
            pose = source.poses()[list(source.frames).index(camera.frame)]
            forward = rotated(pose[3:], rotated(camera.quat_wxyz, np.array([[0.0, 0.0, -1.0]])))
            return view_axes(forward[0]), float(np.deg2rad(camera.fovy))
    azimuth, elevation = np.deg2rad(FREE_CAMERA)
    level = np.cos(elevation)
    forward = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
    return view_axes(forward), float(FOV)


def view_axes(forward: np.ndarray) -> np.ndarray:
    """Return the axes of a camera without roll, as columns; up is as long as forward."""  # (3, 3)
    right = np.cross(forward, (1e-6, 0.0, 1.0))  # not zero when looking straight down
    right /= np.linalg.norm(right)
    return np.column_stack([right, np.cross(right, forward), forward])


def rotated(quat_wxyz: Sequence[float] | np.ndarray, points: np.ndarray) -> np.ndarray:
    """Rotate points by a quaternion."""  # (n, 3)
    return points @ pin.Quaternion(*map(float, quat_wxyz)).matrix().T


def _corners(shape: VisualShape) -> np.ndarray:
    """Return the corners of the box around a shape, in the frame of its body."""  # (8, 3)
    half = np.array(shape.size) / 2.0
    bounds = (-half, half)
    if shape.triangles is not None:
        vertices = shape.triangles.vertices
        bounds = vertices.min(axis=0), vertices.max(axis=0)
    return rotated(shape.quat_wxyz, trimesh.bounds.corners(bounds)) + shape.position
