"""Triangles of geoms with their 2D texture, mapped as in MuJoCo's renderer."""

import itertools
from typing import NamedTuple

import mujoco
import numpy as np

_Geom = mujoco.mjtGeom


class TexturedMesh(NamedTuple):
    """A triangle mesh with a texture, in the frame of its geom."""

    vertices: np.ndarray  # (n, 3) [m]
    normals: np.ndarray  # (n, 3)
    coordinates: np.ndarray
    """Texture coordinates; (0, 0) is the first pixel, and the texture repeats."""  # (n, 2)
    faces: np.ndarray  # (m, 3)
    pixels: np.ndarray
    """Red, green and blue, the top row first, with the material's colour."""  # (h, w, 3)


def textured_mesh(
    model: mujoco.MjModel, geom: int, size: tuple[float, float, float], rgb: tuple[float, ...]
) -> TexturedMesh | None:
    """Return a box, plane, or mesh with texture coordinates; None for other geoms.

    A box is given by its full lengths [m]; ``rgb`` is a factor on the colour of the texture.
    """
    material = int(model.geom_matid[geom])
    texture = texture_of(model, material)
    if texture < 0 or model.tex_type[texture] != mujoco.mjtTexture.mjTEXTURE_2D:
        return None
    kind, mesh = _Geom(int(model.geom_type[geom])), int(model.geom_dataid[geom])
    if kind in (_Geom.mjGEOM_BOX, _Geom.mjGEOM_PLANE):
        half = np.array(size) / 2.0
        surface = _box(half)
    elif kind == _Geom.mjGEOM_MESH and model.mesh_texcoordadr[mesh] >= 0:
        half = model.geom_size[geom]
        surface = _mesh(model, mesh)
    else:
        return None
    repeat = model.mat_texrepeat[material]
    if model.mat_texuniform[material]:
        repeat = repeat * half[:2]
    vertices, normals, coordinates, faces = surface
    pixels = np.rint(pixels_of(model, texture) * np.array(rgb)).astype(np.uint8)
    return TexturedMesh(vertices, normals, coordinates * repeat, faces, pixels)


def texture_of(model: mujoco.MjModel, material: int) -> int:
    """Return the colour texture of a material; -1 without one."""
    if material < 0:
        return -1
    return int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])


def pixels_of(model: mujoco.MjModel, texture: int) -> np.ndarray:
    """Return the colours of a texture; sides of a cube are below each other."""  # (h, w, 3)
    channels = int(model.tex_nchannel[texture])
    height, width = int(model.tex_height[texture]), int(model.tex_width[texture])
    first = int(model.tex_adr[texture])
    pixels = model.tex_data[first : first + height * width * channels]
    return np.broadcast_to(pixels.reshape(height, width, channels)[..., :3], (height, width, 3))


def _box(half: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return a box with the whole texture on each side."""
    across, up = np.array((-1, 1, 1, -1)), np.array((-1, -1, 1, 1))
    sides = []
    for axis, side in itertools.product(range(3), (1, -1)):
        corners = np.full((4, 3), side)
        corners[:, [i for i in range(3) if i != axis]] = np.column_stack([across, up])
        quad = [(0, 1, 2), (0, 2, 3)]
        if (side > 0) == (axis == 1):  # from outside, the two axes are left-handed
            quad = [part[::-1] for part in quad]
        sides.append((corners, np.tile(side * np.eye(3)[axis], (4, 1)), quad))
    corners, normals, quads = (np.array(part) for part in zip(*sides, strict=True))
    faces = (quads + 4 * np.arange(6)[:, None, None]).reshape(-1, 3)
    coordinates = np.tile(np.column_stack([across + 1, 1 - up]) / 2.0, (6, 1))
    return corners.reshape(-1, 3) * half, normals.reshape(-1, 3), coordinates, faces


def _mesh(model: mujoco.MjModel, mesh: int) -> tuple[np.ndarray, ...]:
    """Return a mesh; a vertex is repeated for each of its normals and coordinates."""
    corners = model.mesh_face, model.mesh_facenormal, model.mesh_facetexcoord
    (vertices, normals, coordinates), faces = mesh_corners(model, mesh, *corners)
    return (
        model.mesh_vert[model.mesh_vertadr[mesh] + vertices],
        model.mesh_normal[model.mesh_normaladr[mesh] + normals],
        model.mesh_texcoord[model.mesh_texcoordadr[mesh] + coordinates],
        faces,
    )


def mesh_corners(
    model: mujoco.MjModel, mesh: int, *corners: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the different corners of a mesh, and its faces.

    A corner has an index in each of some arrays: vertices, normals or texture coordinates.
    """  # (len(corners), k), (m, 3)
    first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    rows = np.stack([part[first : first + count].ravel() for part in corners], axis=1)
    unique, indices = np.unique(rows, axis=0, return_inverse=True)
    return unique.T, indices.reshape(-1, 3)
