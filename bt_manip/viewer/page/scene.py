"""The scene of the page: the visible geometry of a cell, and the poses of its bodies."""

from typing import Any, NamedTuple

import mujoco
import numpy as np
import trimesh

from bt_manip.cell import Cell, entity_of
from bt_manip.viewer.window import aim

PLANE_SIZE = 10.0
"""Edge length of the square that stands for an infinite plane [m]."""

VISIBLE_GROUPS = 3
"""Geoms of the groups below this number are visible, as in MuJoCo's viewers."""

DEFAULT_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom that has none: its material's colour is used instead."""

TEXTURE_SAMPLES = 5_000
"""Number of pixels whose mean is the colour of a texture; all would take milliseconds."""

SMALLEST_MOTION = 1e-5
"""Smallest change of a pose that is sent, in position [m] and quaternion."""

_Geom = mujoco.mjtGeom


class Surface(NamedTuple):
    """Triangles of a geom in its frame."""

    vertices: np.ndarray  # (n, 3) [m]
    faces: np.ndarray  # (m, 3)
    flat: bool
    """Whether its edges are sharp although its triangles share vertices."""


class SceneView:
    """Shows a cell in viser: a node for each entity, in it one for each body with its geoms.

    Geometry is sent once for each entity. Entities that come and go add and remove only their own
    nodes, in `bind`; `update` sends the poses that have changed.
    """

    def __init__(self, server: Any) -> None:
        """Start with an empty scene.

        Args:
            server: The ``viser.ViserServer``.
        """
        self._server = server
        self._shown: dict[str, tuple[Any, bytes]] = {}  # entities and their colours, by name
        self._nodes: dict[str, Any] = {}  # by entity
        self._frames: dict[str, dict[str, Any]] = {}  # by entity and body
        self._roots: dict[str, str] = {}  # names of the nodes of entities
        self._bound: list[Any] = []
        self._has_camera = False

    def bind(self, cell: Cell) -> None:
        """Show the entities that the cell has now, with their colours."""
        model, self._data = cell.model, cell.data
        names = [model.body(i).name.rstrip("/") or f"body{i}" for i in range(model.nbody)]
        geoms: dict[str, list[int]] = {}
        for geom in np.flatnonzero(model.geom_group < VISIBLE_GROUPS).tolist():
            geoms.setdefault(entity_of(names[model.geom_bodyid[geom]]), []).append(geom)
        with self._server.atomic():
            for name in [name for name in self._shown if name not in geoms]:
                self._remove(name)
            for name, ids in geoms.items():
                colours = model.geom_rgba[ids].tobytes() + model.geom_matid[ids].tobytes()
                looks = (cell.entities.get(name), colours)
                if self._shown.get(name) != looks:
                    self._remove(name)
                    self._shown[name] = looks
                    self._add(name, ids, names, model)
        index = {name: i for i, name in enumerate(names)}
        frames = {body: node for bodies in self._frames.values() for body, node in bodies.items()}
        self._bound = list(frames.values())
        self._ids = np.array([index[body] for body in frames], dtype=int)
        self._sent = np.full((len(self._ids), 7), np.nan)
        if not self._has_camera:
            self._has_camera = True
            self._aim(model)
        self.update()

    def update(self) -> None:
        """Send the poses that have changed."""
        poses = np.hstack([self._data.xpos[self._ids], self._data.xquat[self._ids]])
        still = np.all(np.abs(poses - self._sent) < SMALLEST_MOTION, axis=1)  # NaN: not sent yet
        moved = np.flatnonzero(~still).tolist()
        if not moved:
            return
        with self._server.atomic():
            for i in moved:
                node = self._bound[i]
                node.position, node.wxyz = poses[i, :3], poses[i, 3:]
        self._sent[moved] = poses[moved]

    # Internal

    def _remove(self, name: str) -> None:
        if self._shown.pop(name, None) is not None:
            self._nodes.pop(name).remove()
            del self._frames[name]

    def _add(self, name: str, geoms: list[int], names: list[str], model: mujoco.MjModel) -> None:
        scene = self._server.scene
        # A new name: one that replaces another at once has been drawn at the old pose.
        root = self._roots[name] = (
            f"/{name}" if self._roots.get(name) != f"/{name}" else f"/{name}:"
        )
        self._nodes[name] = scene.add_frame(root, show_axes=False)
        frames = self._frames[name] = {}
        for geom in geoms:
            surface = surface_of(model, geom)
            if surface is None:
                continue
            body = names[model.geom_bodyid[geom]]
            # Poses are those in the world: bodies are no children of each other.
            path = f"{root}/{body.replace('/', ':')}"
            if body not in frames:
                frames[body] = scene.add_frame(path, show_axes=False)
            *rgb, alpha = colour_of(model, geom)
            scene.add_mesh_simple(
                f"{path}/{geom_name(model, geom)}",
                surface.vertices,
                surface.faces,
                color=tuple(round(255 * part) for part in rgb),
                opacity=None if alpha >= 1.0 else alpha,
                flat_shading=surface.flat,
                position=model.geom_pos[geom],
                wxyz=model.geom_quat[geom],
            )

    def _aim(self, model: mujoco.MjModel) -> None:
        """Give pages that are opened the viewpoint of the overview camera."""
        camera, first = mujoco.MjvCamera(), self._server.initial_camera
        aim(camera, model, self._data)
        azimuth, elevation = np.deg2rad([camera.azimuth, camera.elevation])
        level = np.cos(elevation)
        forward = np.array([level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)])
        first.position = camera.lookat - camera.distance * forward
        first.look_at = camera.lookat.copy()
        first.fov = float(np.deg2rad(model.vis.global_.fovy))


def surface_of(model: mujoco.MjModel, geom: int) -> Surface | None:
    """Return the triangles of a geom; None for kinds that are not drawn (height fields)."""
    x, y, z = model.geom_size[geom].tolist()
    kind = _Geom(int(model.geom_type[geom]))
    if kind in (_Geom.mjGEOM_MESH, _Geom.mjGEOM_SDF):
        return _mesh(model, int(model.geom_dataid[geom]))
    make = trimesh.creation
    if kind == _Geom.mjGEOM_BOX:
        shape = make.box((2 * x, 2 * y, 2 * z))
    elif kind == _Geom.mjGEOM_PLANE:
        shape = make.box((2 * x or PLANE_SIZE, 2 * y or PLANE_SIZE, 1e-4))
    elif kind == _Geom.mjGEOM_CYLINDER:
        shape = make.cylinder(x, 2 * y, sections=48)
    elif kind == _Geom.mjGEOM_CAPSULE:
        shape = make.capsule(2 * y, x)
    elif kind in (_Geom.mjGEOM_SPHERE, _Geom.mjGEOM_ELLIPSOID):
        shape = make.icosphere(3)
        shape.apply_scale((x, x, x) if kind == _Geom.mjGEOM_SPHERE else (x, y, z))
    else:
        return None
    flat = kind in (_Geom.mjGEOM_BOX, _Geom.mjGEOM_PLANE, _Geom.mjGEOM_CYLINDER)
    return Surface(np.asarray(shape.vertices), np.asarray(shape.faces), flat)


def _mesh(model: mujoco.MjModel, mesh: int) -> Surface:
    first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
    corners = slice(first, first + count)
    # A vertex with several normals is at a sharp edge: it becomes several vertices.
    faces, normals = model.mesh_face[corners], model.mesh_facenormal[corners]
    pairs = np.stack([faces.ravel(), normals.ravel()], axis=1)
    unique, indices = np.unique(pairs, axis=0, return_inverse=True)
    return Surface(
        model.mesh_vert[model.mesh_vertadr[mesh] + unique[:, 0]], indices.reshape(-1, 3), False
    )


def colour_of(model: mujoco.MjModel, geom: int) -> tuple[float, ...]:
    """Return red, green, blue and opacity of a geom, from 0 to 1; textures become their mean."""
    colour = tuple(model.geom_rgba[geom].tolist())
    material = int(model.geom_matid[geom])
    if material < 0:
        return colour
    if colour == DEFAULT_COLOUR:
        colour = tuple(model.mat_rgba[material].tolist())
    texture = int(model.mat_texid[material, mujoco.mjtTextureRole.mjTEXROLE_RGB])
    if texture < 0:
        return colour
    first, channels = int(model.tex_adr[texture]), int(model.tex_nchannel[texture])
    size = int(model.tex_height[texture]) * int(model.tex_width[texture]) * channels
    pixels = model.tex_data[first : first + size].reshape(-1, channels)
    sample = pixels[:: max(1, len(pixels) // TEXTURE_SAMPLES), :3]
    mean = sample.mean(axis=0) / 255.0
    return (*(np.broadcast_to(mean, 3) * colour[:3]).tolist(), colour[3])


def geom_name(model: mujoco.MjModel, geom: int) -> str:
    """Return a name of a geom that is unique in its body."""
    return f"geom{geom - int(model.body_geomadr[model.geom_bodyid[geom]])}"
