"""The visible geometry of a cell, for viewers, recordings and exports."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple, Protocol

import mujoco
import numpy as np

from bt_manip.cell import WORLD, entity_of, literal_name
from bt_manip_recording.textured_mesh import (
    TexturedMesh,
    mesh_corners,
    pixels_of,
    texture_of,
    textured_mesh,
)

PLANE_SIZE = 10.0
"""Edge length of the square that represents an infinite plane [m]."""

PLANE_THICKNESS = 1e-4
"""Thickness of the box that represents a plane [m]."""

VISIBLE_GROUPS = 3
"""Geoms of the groups below this number are visible, as in MuJoCo's viewers."""

DEFAULT_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's default colour, in place of which a geom has the colour of its material."""

TEXTURE_SAMPLES = 5_000
"""Number of averaged pixels of a texture; all pixels would take milliseconds."""

_Geom = mujoco.mjtGeom


class Triangles(NamedTuple):
    """A triangle mesh; a vertex at a sharp edge is repeated for each side."""

    vertices: np.ndarray  # (n, 3) [m]
    faces: np.ndarray  # (m, 3)


class VisualShape(NamedTuple):
    """A visible shape in the frame of its body.

    Capsules are cylinders with two ellipsoids, planes are thin boxes.
    """

    kind: Literal["box", "ellipsoid", "cylinder", "mesh"]
    position: np.ndarray  # (3,) [m]
    quat_wxyz: np.ndarray  # (4,)
    rgba: tuple[float, ...]
    """Red, green, blue and opacity, from 0 to 1; the mean colour of a texture."""
    size: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Full lengths along the axes of the shape [m]; the axis of a cylinder is z."""
    triangles: Triangles | None = None
    """The triangles of a mesh."""
    textured: TexturedMesh | None = None
    """The same surface with its texture, if any."""


class SceneCamera(NamedTuple):
    """A camera of a cell; as in MuJoCo it looks along its -z axis, with y up."""

    name: str
    frame: str
    """Name of the body to which it is fixed."""
    position: np.ndarray  # (3,) [m] in that frame
    quat_wxyz: np.ndarray  # (4,)
    fovy: float
    """Vertical field of view [deg]."""


class SceneSource(Protocol):
    """Data of a cell for viewers, live (`CellScene`) or recorded (`RecordedScene`).

    Entities have bodies, bodies have frames and shapes. Geometry changes seldom: a viewer compares
    `entities` with the displayed ones, reads the `shapes` of entities that are new or look
    different, and then reads `poses` as often as needed. When objects are added or removed, a live
    cell gets a new source with other frames; a recording has one source.

    Attributes:
        frames: Names of the frames of the bodies, in the order of `poses`; no name occurs twice.
        cameras: The cameras.
        centre: Centre of the cell [m]; viewers without a camera `OVERVIEW` look at it.  # (3,)
        extent: Size of the cell [m].
    """

    @property
    def frames(self) -> Sequence[str]: ...  # noqa: D102
    @property
    def cameras(self) -> Sequence[SceneCamera]: ...  # noqa: D102
    @property
    def centre(self) -> np.ndarray: ...  # noqa: D102
    @property
    def extent(self) -> float: ...  # noqa: D102

    def entities(self) -> Mapping[str, Any]:
        """Return the present entities by name, with a value that identifies their appearance.

        The entity ``world`` has the bodies that belong to no other entity.
        """

    def shapes(self, entity: str) -> Mapping[str, Sequence[VisualShape]]:
        """Return the visible shapes of a present entity, by frame."""

    def poses(self) -> np.ndarray:
        """Return positions [m] and quaternions (wxyz) of the frames in the world.

        Values of absent bodies are undefined.
        """  # (n, 7)


class CellScene:
    """The scene of a compiled model and its present state, as a `SceneSource`.

    Args:
        model: The compiled model.
        data: Its data.
        entities: The entities by name; an entity object identifies an appearance.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        entities: Mapping[str, Any] | None = None,
    ) -> None:
        self._model, self._data, self._known = model, data, dict(entities or {})
        self.frames = [_frame_name(model, i) for i in range(model.nbody)]
        names = [entity_of(name) for name in self.frames]
        order = list(dict.fromkeys(names))
        of_body = np.array([order.index(name) for name in names])
        visible = np.where(model.geom_group < VISIBLE_GROUPS, of_body[model.geom_bodyid], -1)
        self._geoms = {name: np.flatnonzero(visible == i) for i, name in enumerate(order)}
        self.cameras = [
            SceneCamera(
                mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_CAMERA, i) or f"camera{i}",
                self.frames[model.cam_bodyid[i]],
                model.cam_pos[i].copy(),
                model.cam_quat[i].copy(),
                float(model.cam_fovy[i]),
            )
            for i in range(model.ncam)
        ]
        self.centre, self.extent = model.stat.center.copy(), float(model.stat.extent)

    def entities(self) -> dict[str, Any]:
        """Return all entities, each with its object and colours."""
        rgba, material = self._model.geom_rgba, self._model.geom_matid
        return {
            name: (self._known.get(name), rgba[ids].tobytes() + material[ids].tobytes())
            for name, ids in self._geoms.items()
        }

    def shapes(self, entity: str) -> dict[str, list[VisualShape]]:
        """Return the visible shapes of an entity, by frame."""
        found: dict[str, list[VisualShape]] = {}
        for geom in self._geoms[entity].tolist():
            frame = self.frames[self._model.geom_bodyid[geom]]
            found.setdefault(frame, []).extend(_shapes_of(self._model, geom))
        return found

    def poses(self) -> np.ndarray:
        """Return the present poses of all bodies."""
        return np.hstack([self._data.xpos, self._data.xquat])


def _frame_name(model: mujoco.MjModel, body: int) -> str:
    if body == 0:
        return WORLD
    name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body{body}"
    return literal_name(name.rstrip("/"))


def _shapes_of(model: mujoco.MjModel, geom: int) -> list[VisualShape]:
    """Return the shapes of a geom; none for height fields."""
    x, y, z = model.geom_size[geom].tolist()
    position, quat_wxyz = model.geom_pos[geom].copy(), model.geom_quat[geom].copy()
    rgba = _colour_of(model, geom)
    kind = _Geom(int(model.geom_type[geom]))
    if kind in (_Geom.mjGEOM_MESH, _Geom.mjGEOM_SDF):
        mesh = int(model.geom_dataid[geom])
        (vertices, _), faces = mesh_corners(model, mesh, model.mesh_face, model.mesh_facenormal)
        triangles = Triangles(model.mesh_vert[model.mesh_vertadr[mesh] + vertices], faces)
        mesh_shape = VisualShape("mesh", position, quat_wxyz, rgba, triangles=triangles)
        return [_with_texture(model, geom, mesh_shape)]
    ball = 2 * x, 2 * x, 2 * x
    solids: dict[Any, tuple[Any, tuple[float, float, float]]] = {
        _Geom.mjGEOM_BOX: ("box", (2 * x, 2 * y, 2 * z)),
        _Geom.mjGEOM_PLANE: ("box", (2 * x or PLANE_SIZE, 2 * y or PLANE_SIZE, PLANE_THICKNESS)),
        _Geom.mjGEOM_ELLIPSOID: ("ellipsoid", (2 * x, 2 * y, 2 * z)),
        _Geom.mjGEOM_SPHERE: ("ellipsoid", ball),
        _Geom.mjGEOM_CYLINDER: ("cylinder", (2 * x, 2 * x, 2 * y)),
        _Geom.mjGEOM_CAPSULE: ("cylinder", (2 * x, 2 * x, 2 * y)),
    }
    if kind not in solids:
        return []
    name, size = solids[kind]
    found = [_with_texture(model, geom, VisualShape(name, position, quat_wxyz, rgba, size))]
    if kind == _Geom.mjGEOM_CAPSULE:
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, quat_wxyz)
        for end in (-y, y):
            found.append(
                found[0]._replace(kind="ellipsoid", position=position + end * axes[2::3], size=ball)
            )
    return found


def _with_texture(model: mujoco.MjModel, geom: int, shape: VisualShape) -> VisualShape:
    """Return the shape of a geom, with the mean colour of its texture."""
    texture = texture_of(model, int(model.geom_matid[geom]))
    if texture < 0:
        return shape
    textured = textured_mesh(model, geom, shape.size, shape.rgba[:3])
    pixels = pixels_of(model, texture).reshape(-1, 3)
    mean = pixels[:: max(1, len(pixels) // TEXTURE_SAMPLES)].mean(axis=0) / 255.0
    rgba = (*(mean * shape.rgba[:3]).tolist(), shape.rgba[3])
    return shape._replace(rgba=rgba, textured=textured)


def _colour_of(model: mujoco.MjModel, geom: int) -> tuple[float, ...]:
    """Return the colour of a geom without its texture."""
    colour = tuple(model.geom_rgba[geom].tolist())
    material = int(model.geom_matid[geom])
    if material >= 0 and colour == DEFAULT_COLOUR:
        colour = tuple(model.mat_rgba[material].tolist())
    return colour
