"""Grasps of a suction cup on the faces of an object."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.grippers import Polyhedron, Solid
from bt_manip.robots import GraspCandidates

from .lip import LIP_RADIUS, MAX_SAG, ring

CURVATURE_WEIGHT = 0.3
"""Cost of the largest curvature on which the cup seals."""

_GAP = 0.2e-3  # [m] between lip and face at a grasp: planned paths end without penetration
_EDGE = 2e-3  # [m] minimum distance from the lip to the edge of a face: the arm's position error
_BUMP = 1e-3  # [m] maximum height of a bump of the surface under the lip
_BELOW = -0.1  # cosine of approach and straight down below which a grasp approaches from below
_MAX_FACES = 32  # considered faces of a solid, the largest first
_TOLERANCE = 4  # digits of normals and offsets [m] to which triangles belong to one face
_QUARTERS = tuple(math.pi * k / 4 for k in (0, 1, -1, 2, -2))  # [rad] from the vertical
_EIGHTHS = tuple(0.25 * math.pi * k for k in range(8))  # [rad] of a turn

Place = tuple[np.ndarray, np.ndarray]
"""A surface point [m] and its outward normal, in the object's frame."""


class CupGraspGenerator:
    """Generates the grasp candidates of one object for a suction cup.

    Candidate points are near the centre of mass on each flat face, and on balls, cylinders and
    other round solids. A point is accepted if rays along the axis of the cup hit the object under
    the whole lip, at most as deep as the cup seals.

    Args:
        hollow: Whether round faces reach into the cup, until they touch the inside of the lip.

    Attributes:
        name: Name of the object, for messages.
        solids: Its convex solids.
        radius: Radius of the cup's lip [m].
        com: Its centre of mass, in its frame [m].  # (3,)
    """

    def __init__(
        self,
        name: str,
        solids: Sequence[Solid],
        radius: float,
        com: np.ndarray,
        *,
        hollow: bool = True,
    ) -> None:
        self._hollow = hollow
        self.name, self.solids, self.radius, self.com = name, list(solids), radius, np.array(com)

    def candidates(self, down: np.ndarray) -> GraspCandidates:
        """Return the grasps that do not approach from below.

        Raises:
            MotionError: If the object has no face for the cup.
        """
        places = [
            place
            for solid in self.solids
            for place in places_on(solid, self.com, self.radius, -down)
            if -place[1] @ down >= _BELOW
        ]
        surface: np.ndarray = np.reshape(places, (-1, 2, 3))
        points, normals = surface[:, 0], surface[:, 1]
        depth = self._depth(points, normals, self.radius)
        beside = self._depth(points, normals, self.radius + _EDGE)
        limit = MAX_SAG * self.radius
        kept = (np.maximum(depth, np.where(beside < np.inf, 0.0, np.inf)) <= limit).all(axis=1)
        kept &= (np.minimum(depth, beside) >= -_BUMP).all(axis=1)
        if not kept.any():
            raise MotionError(
                f"'{self.name}' has no face that a cup of {2e3 * self.radius:.0f} mm seals on",
                reason="grasp",
            )
        frames = np.array([_frame(-normal) for normal in normals[kept]])
        inside = self._depth(points, normals, self.radius - 2.0 * LIP_RADIUS)[kept].min(axis=1)
        shift = _GAP - (inside.clip(min=0.0) if self._hollow else 0.0)
        lips = points[kept] + np.reshape(shift, (-1, 1)) * normals[kept]
        cost = CURVATURE_WEIGHT * np.clip(depth[kept].max(axis=1) / limit, 0.0, 1.0)
        return GraspCandidates(
            frames,
            lips,
            np.zeros(len(lips)),
            np.ones(len(lips)),
            {"curvature": cost},
            free_axis=frames[:, :, 2],
            pivot=lips,
        )

    def _depth(self, points: np.ndarray, normals: np.ndarray, radius: float) -> np.ndarray:
        """Return the depth of the surface under a ring around each surface point [m].

        Rays start one radius of the cup above the surface. The depth is inf where they hit nothing.
        """  # (n, rays)
        rings = np.array([ring(radius) @ _frame(-normal).T for normal in normals])
        starts = (points + self.radius * normals)[:, None] + rings.reshape(len(points), -1, 3)
        along = np.broadcast_to(-normals[:, None], starts.shape).reshape(-1, 3)
        hits = [_hits(solid.polyhedron, starts.reshape(-1, 3), along) for solid in self.solids]
        return np.min(hits, axis=0).reshape(starts.shape[:2]) - self.radius


def places_on(solid: Solid, com: np.ndarray, radius: float, up: np.ndarray) -> Iterator[Place]:
    """Yield points and normals for a cup: on faces near the centre of mass, and on round sides.

    All is in the object's frame, as is ``up``; the radius is that of the lip [m].
    """
    centre, R, size = solid.T_os.translation, solid.T_os.rotation, solid.size
    if solid.kind == "sphere":
        frame = _frame(up)
        for tilt in (0.0, math.pi / 4, math.pi / 2):
            for a in _EIGHTHS if tilt else (0.0,):
                s, c = math.sin(tilt), math.cos(tilt)
                normal = frame @ np.array([s * math.cos(a), s * math.sin(a), c])
                yield centre + size[0] * normal, normal
        return
    if solid.kind == "ellipsoid":
        for normal in (up, *R.T, *-R.T):
            along = R.T @ normal * size
            yield centre + R @ (along * size) / np.linalg.norm(along), normal
        return
    if solid.kind in ("cylinder", "capsule"):
        axis, half = R[:, 2], float(size[1])
        free = max(half - radius - _EDGE, 0.0)
        middle = centre + np.clip((com - centre) @ axis, -free, free) * axis
        frame = _frame(axis, up)
        for a in _QUARTERS:
            normal = frame @ np.array([math.cos(a), math.sin(a), 0.0])
            yield middle + size[0] * normal, normal
        if solid.kind == "capsule":
            yield centre + (half + size[0]) * axis, axis
            yield centre - (half + size[0]) * axis, -axis
            return
    yield from _face_places(solid.polyhedron, com, math.pi * radius**2)


def _face_places(solid: Polyhedron, com: np.ndarray, least: float) -> Iterator[Place]:
    """Yield points on flat faces with a minimum area [m2], those nearest to the com first.

    They are the projection of the centre of mass, the centroid of the face, and their midpoint.
    """
    edges = solid.triangles[:, 1:] - solid.triangles[:, :1]
    areas = 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    planes = np.round(np.column_stack([solid.normals, solid.offsets]), _TOLERANCE) + 0.0
    _, face = np.unique(planes, axis=0, return_inverse=True)
    area = np.bincount(face, areas)
    for i in np.argsort(-area, kind="stable")[:_MAX_FACES]:
        if area[i] < least:
            return
        own = face == i
        normal, offset = solid.normals[own][0], solid.offsets[own][0]
        centroid = np.average(solid.triangles[own].mean(axis=1), axis=0, weights=areas[own])
        projected = com + (offset - normal @ com) * normal
        apart = np.linalg.norm(centroid - projected) > _EDGE
        for part in (0.0, 0.5, 1.0) if apart else (0.0,):
            yield projected + part * (centroid - projected), normal


def _hits(solid: Polyhedron, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Return the distances at which rays enter a solid [m]; inf where they miss it.

    Cyrus-Beck clipping against the planes of its faces.
    """  # (n,)
    slope = directions @ solid.normals.T
    ahead = solid.offsets - points @ solid.normals.T
    parallel = np.abs(slope) <= 1e-12
    t = ahead / np.where(parallel, 1.0, slope)
    enter = np.where(~parallel & (slope < 0.0), t, -np.inf).max(axis=1)
    leave = np.where(~parallel & (slope > 0.0), t, np.inf).min(axis=1)
    missed = (parallel & (ahead < 0.0)).any(axis=1) | (enter > leave) | (leave < 0.0)
    return np.where(missed, np.inf, enter)


def _frame(z: np.ndarray, x: np.ndarray | None = None) -> np.ndarray:
    """Return a rotation with a z axis, and an x axis near a direction that is not parallel to z."""
    across = np.zeros(3) if x is None else x - (x @ z) * z
    if np.linalg.norm(across) < 1e-3:
        across = np.cross(z, np.eye(3)[int(np.argmin(np.abs(z)))])
    across = across / np.linalg.norm(across)
    return np.column_stack([across, np.cross(z, across), z])
