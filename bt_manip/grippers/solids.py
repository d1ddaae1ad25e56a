"""Convex solids of an object's collision geometry, and their surfaces."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Cell, body_poses, collision_geoms, geom_pose
from bt_manip.exceptions import MotionError

_KINDS = {
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}
SIDEWAYS = (0.0, math.pi / 4, -math.pi / 4, math.pi / 2, -math.pi / 2)  # [rad] from the vertical
_SECTORS = 32  # of the polyhedron that approximates a round solid
_RINGS = 8  # per hemisphere
_QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex solid, the points x with ``normals @ x <= offsets``, and its surface.

    Attributes:
        normals: Outward unit normals, one per triangle.  # (k, 3)
        offsets: Offsets of the planes [m].  # (k,)
        triangles: Corners of the surface triangles [m].  # (k, 3, 3)
    """

    normals: np.ndarray
    offsets: np.ndarray
    triangles: np.ndarray

    @classmethod
    def from_triangles(cls, triangles: np.ndarray) -> "Polyhedron":
        """Return the polyhedron with the triangles of a convex surface, in either winding order.

        Args:
            triangles: Surface triangles; those without area are dropped [m].  # (k, 3, 3)
        """
        edges = triangles[:, 1:] - triangles[:, :1]
        normals = np.cross(edges[:, 0], edges[:, 1])
        area = np.linalg.norm(normals, axis=1)
        some = area > 1e-12 * max(float(area.max()), 1e-12)
        triangles, normals = triangles[some], normals[some] / area[some, None]
        inside = triangles.reshape(-1, 3).mean(axis=0)
        inward = np.einsum("ij,ij->i", normals, triangles[:, 0] - inside) < 0.0
        normals[inward] *= -1.0
        return cls(normals, np.einsum("ij,ij->i", normals, triangles[:, 0]), triangles)


@dataclass(frozen=True, eq=False)
class Solid:
    """One convex solid of an object; a mesh is replaced by its convex hull, as in the physics.

    Attributes:
        kind: ``box``, ``sphere``, ``cylinder``, ``capsule``, ``ellipsoid`` or ``mesh``.
        size: Half lengths or radii as in MuJoCo's ``geom_size`` [m].  # (3,)
        T_os: Its pose in the object's frame.
        friction: Sliding friction of contacts with fingers [-].
        hull: Triangles of a mesh's convex hull, in the frame of the solid [m].  # (n, 3, 3)
    """

    kind: str
    size: np.ndarray
    T_os: pin.SE3
    friction: float
    hull: np.ndarray | None = None

    @cached_property
    def polyhedron(self) -> Polyhedron:
        """The solid as a polyhedron in the object's frame."""
        triangles = surface_triangles(self.kind, self.size) if self.hull is None else self.hull
        return Polyhedron.from_triangles(triangles @ self.T_os.rotation.T + self.T_os.translation)

    def support(self, directions: np.ndarray) -> np.ndarray:
        """Return the support function: the largest coordinate along each direction [m].

        Args:
            directions: Unit vectors in the object's frame.  # (n, 3)
        """  # (n,)
        along = directions @ self.T_os.rotation
        size = self.size
        if self.kind == "box":
            out = np.abs(along) @ size
        elif self.kind == "sphere":
            out = np.full(len(along), size[0])
        elif self.kind == "cylinder":
            out = np.hypot(along[:, 0], along[:, 1]) * size[0] + np.abs(along[:, 2]) * size[1]
        elif self.kind == "capsule":
            out = size[0] + np.abs(along[:, 2]) * size[1]
        elif self.kind == "ellipsoid":
            out = np.linalg.norm(along * size, axis=1)
        else:
            assert self.hull is not None
            out = (along @ self.hull.reshape(-1, 3).T).max(axis=1)
        return np.array(out + directions @ self.T_os.translation)


def solids_of(cell: Cell, name: str) -> list[Solid]:
    """Return the convex solids of an entity's collision geometry.

    They depend on the compiled model and the entity's own joints only, not on its pose.

    Raises:
        CellError: If there is no such entity.
        MotionError: If it has no collision geometry.
    """
    model = cell.model
    geoms = collision_geoms(cell, name).tolist()
    poses = body_poses(model, cell.body_id(name), cell.data.qpos)
    solids = []
    for geom in geoms:
        kind = _kind(model, geom)
        if kind is None:
            continue
        mesh = int(model.geom_dataid[geom])
        hull = _mesh_hull(model, mesh) if kind == "mesh" else None
        T_os = geom_pose(model, poses, geom)
        friction = float(model.geom_friction[geom, 0])
        size = np.array(model.geom_size[geom])
        solids.append(Solid(kind, size, T_os, friction, hull))
    if not solids:
        raise MotionError(f"'{name}' has no collision geometry to grip", reason="grasp")
    return solids


def contact_friction(solids: Sequence[Solid]) -> float:
    """Return the sliding friction of contacts between fingers and an object [-].

    This is the smallest friction of its solids: fingers have zero friction, and MuJoCo uses the
    larger value of two geoms.
    """
    return min(solid.friction for solid in solids)


def least_width(solids: Sequence[Solid]) -> float:
    """Return the minimum distance between two parallel planes that enclose an object [m].

    The minimum is taken over the face normals. It is exact for polyhedra, and for a single
    cylinder, capsule or sphere.
    """
    normals = np.concatenate([solid.polyhedron.normals for solid in solids])
    upper, lower = (np.max([s.support(d) for s in solids], axis=0) for d in (normals, -normals))
    return float((upper + lower).min())


def surface_triangles(kind: str, size: np.ndarray) -> np.ndarray:
    """Return the surface triangles of a primitive; round ones as an inscribed polyhedron [m].

    Args:
        kind: ``box``, ``sphere``, ``cylinder``, ``capsule`` or ``ellipsoid``.
        size: Half lengths or radii as in MuJoCo's ``geom_size`` [m].  # (3,)
    """  # (k, 3, 3)
    if kind == "box":
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        quads = (signs * size)[np.array(_QUADS)]
        return np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    if kind == "cylinder":
        r, h = float(size[0]), float(size[1])
        return _surface_of_revolution(np.array([[0.0, -h], [r, -h], [r, h], [0.0, h]]))
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * _RINGS + 1)
    arc = np.column_stack([np.cos(latitude), np.sin(latitude)])
    if kind == "ellipsoid":
        return _surface_of_revolution(arc) * size
    arc = float(size[0]) * arc
    if kind == "capsule":
        ends = np.insert(arc, _RINGS, arc[_RINGS], axis=0)
        ends[: _RINGS + 1, 1] -= size[1]
        ends[_RINGS + 1 :, 1] += size[1]
        arc = ends
    return _surface_of_revolution(arc)


def geom_surface(model: mujoco.MjModel, geom: int) -> np.ndarray:
    """Return the triangles of a collision geom's surface, in its frame [m].

    A mesh is replaced by its convex hull, a round primitive by an inscribed polyhedron; planes and
    height fields have none.
    """  # (k, 3, 3)
    kind = _kind(model, geom)
    if kind is None:
        return np.zeros((0, 3, 3))
    if kind == "mesh":
        return _mesh_hull(model, int(model.geom_dataid[geom]))
    return surface_triangles(kind, np.array(model.geom_size[geom]))


def collision_geoms_of(model: mujoco.MjModel, body: int) -> list[int]:
    """List the ids of the collision geoms of a body."""
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    return [int(g) for g in np.flatnonzero((model.geom_bodyid == body) & collides)]


class BodySurface:
    """Surface of a body's collision geometry; meshes are replaced by their convex hulls.

    Args:
        model: The compiled model.
        body: Id of the body, also the attribute of this name.
    """

    def __init__(self, model: mujoco.MjModel, body: int) -> None:
        self.body = body
        found = [np.zeros((0, 3, 3))]
        for geom in collision_geoms_of(model, body):
            T_bg = spatial.pose(model.geom_pos[geom], model.geom_quat[geom])
            found.append(geom_surface(model, geom) @ T_bg.rotation.T + T_bg.translation)
        self._triangles = np.concatenate(found)

    def beyond(self, T_tb: pin.SE3, height: float) -> np.ndarray:
        """Return the corners of the part of the surface above a plane z = height [m].

        Args:
            T_tb: Pose of the body in a frame whose z axis is normal to the plane.
            height: Height of the plane [m]; minus infinity for the whole surface.
        """  # (n, 3)
        a = self._triangles @ T_tb.rotation.T + T_tb.translation
        b = np.roll(a, -1, axis=1)
        start, end = a[..., 2] - height, b[..., 2] - height
        cross = (start < 0.0) != (end < 0.0)
        t = start[cross] / (start[cross] - end[cross])
        return np.concatenate([a[start >= 0.0], a[cross] + t[:, None] * (b[cross] - a[cross])])


def _kind(model: mujoco.MjModel, geom: int) -> str | None:
    return _KINDS.get(int(model.geom_type[geom]))


def _mesh_hull(model: mujoco.MjModel, mesh: int) -> np.ndarray:
    """Return the triangles of the convex hull that MuJoCo's compiler computed for a mesh [m].

    From ``mesh_graphadr`` on, ``mesh_graph`` holds the numbers of vertices and faces, two numbers
    per vertex, three edge numbers per face, and the three vertices of each face.
    """  # (k, 3, 3)
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.array(model.mesh_vert[first : first + count], dtype=float)
    start = int(model.mesh_graphadr[mesh])
    n_vertices, n_faces = (int(n) for n in model.mesh_graph[start : start + 2])
    start += 2 + 2 * n_vertices + n_vertices + 3 * n_faces
    faces = np.array(model.mesh_graph[start : start + 3 * n_faces]).reshape(-1, 3)
    return vertices[faces]


def _surface_of_revolution(profile: np.ndarray) -> np.ndarray:
    """Revolve a profile of radii and heights about the z axis [m]."""  # (k, 3, 3)
    angle = 2.0 * np.pi * np.arange(_SECTORS + 1) / _SECTORS
    radius, height = profile.T
    rings = np.stack(
        [
            radius[:, None] * np.cos(angle),
            radius[:, None] * np.sin(angle),
            np.repeat(height[:, None], len(angle), axis=1),
        ],
        axis=2,
    )
    a, b, c, d = rings[:-1, :-1], rings[1:, :-1], rings[1:, 1:], rings[:-1, 1:]
    quads = np.stack([np.stack([a, b, c], axis=2), np.stack([a, c, d], axis=2)])
    return np.array(quads.reshape(-1, 3, 3))
