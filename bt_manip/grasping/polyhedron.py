"""Convex solids bounded by planes."""

from dataclasses import dataclass

import mujoco
import numpy as np

_SIDES = 32  # of a round solid
_RINGS = 8  # of half a ball
_QUADS = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A convex solid as the places x with ``normals @ x <= offsets``, and its surface.

    Attributes:
        normals: Outward, unit; one for each triangle.  # (k, 3)
        offsets: [m].  # (k,)
        triangles: Corners of its surface [m].  # (k, 3, 3)
    """

    normals: np.ndarray
    offsets: np.ndarray
    triangles: np.ndarray


def bounded_by(triangles: np.ndarray) -> Polyhedron:
    """Make a polyhedron of the triangles of a convex surface, whichever way round they are.

    Args:
        triangles: Those of no area are left out [m].  # (k, 3, 3)
    """
    edges = triangles[:, 1:] - triangles[:, :1]
    normals = np.cross(edges[:, 0], edges[:, 1])
    area = np.linalg.norm(normals, axis=1)
    some = area > 1e-12 * max(float(area.max()), 1e-12)
    triangles, normals = triangles[some], normals[some] / area[some, None]
    inside = triangles.reshape(-1, 3).mean(axis=0)
    inward = np.einsum("ij,ij->i", normals, triangles[:, 0] - inside) < 0.0
    normals[inward] *= -1.0
    return Polyhedron(normals, np.einsum("ij,ij->i", normals, triangles[:, 0]), triangles)


def triangles_of(kind: str, size: np.ndarray) -> np.ndarray:
    """Give the surface of a solid, a round one as a polyhedron of many sides inside it.

    Args:
        kind: ``box``, ``sphere``, ``cylinder``, ``capsule`` or ``ellipsoid``.
        size: Half lengths or radii as MuJoCo has them [m].  # (3,)
    """  # (k, 3, 3)
    if kind == "box":
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        quads = (signs * size)[np.array(_QUADS)]
        return np.concatenate([quads[:, :3], quads[:, [0, 2, 3]]])
    if kind == "cylinder":
        r, h = float(size[0]), float(size[1])
        return _revolved(np.array([[0.0, -h], [r, -h], [r, h], [0.0, h]]))
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * _RINGS + 1)
    arc = np.column_stack([np.cos(latitude), np.sin(latitude)])
    if kind == "ellipsoid":
        return _revolved(arc) * size
    arc = float(size[0]) * arc
    if kind == "capsule":
        ends = np.insert(arc, _RINGS, arc[_RINGS], axis=0)
        ends[: _RINGS + 1, 1] -= size[1]
        ends[_RINGS + 1 :, 1] += size[1]
        arc = ends
    return _revolved(arc)


def hull_of_mesh(model: mujoco.MjModel, mesh: int) -> np.ndarray:
    """Give the convex hull that a mesh collides as, as MuJoCo's compiler made it.

    ``mesh_graph`` holds, from ``mesh_graphadr`` on, the numbers of its vertices and faces, two
    numbers a vertex, three times as many a face as edges, and the vertices of each face.
    """  # (k, 3, 3)
    first, count = int(model.mesh_vertadr[mesh]), int(model.mesh_vertnum[mesh])
    vertices = np.array(model.mesh_vert[first : first + count], dtype=float)
    start = int(model.mesh_graphadr[mesh])
    n_vertices, n_faces = (int(n) for n in model.mesh_graph[start : start + 2])
    start += 2 + 2 * n_vertices + n_vertices + 3 * n_faces
    faces = np.array(model.mesh_graph[start : start + 3 * n_faces]).reshape(-1, 3)
    return vertices[faces]


def _revolved(profile: np.ndarray) -> np.ndarray:
    """Turn a profile of radii and heights about the z axis [m]."""  # (k, 3, 3)
    angle = 2.0 * np.pi * np.arange(_SIDES + 1) / _SIDES
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
