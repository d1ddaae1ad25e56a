"""The bounding box of a model."""

from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

_Geom = mujoco.mjtGeom


class Bounds(NamedTuple):
    """A box along the axes of a model's frame."""

    lower: np.ndarray  # (3,) [m]
    upper: np.ndarray  # (3,) [m]

    @property
    def size(self) -> np.ndarray:
        """Lengths of its edges [m]."""  # (3,)
        return self.upper - self.lower

    @property
    def centre(self) -> np.ndarray:
        """Its centre [m]."""  # (3,)
        return 0.5 * (self.upper + self.lower)


def bounds_of(model: mujoco.MjModel) -> Bounds:
    """Return the bounding box of a model's collision shapes, or without any, of all shapes.

    Planes are infinite and do not count.
    """
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    finite = model.geom_type != _Geom.mjGEOM_PLANE
    collides = finite & ((model.geom_contype != 0) | (model.geom_conaffinity != 0))
    geoms = np.flatnonzero(collides if collides.any() else finite)
    if not len(geoms):
        return Bounds(np.zeros(3), np.zeros(3))
    boxes = [geom_box(model, data, int(geom)) for geom in geoms]
    lower, upper = (np.array(part) for part in zip(*boxes, strict=True))
    return Bounds(lower.min(axis=0), upper.max(axis=0))


def geom_box(
    model: mujoco.MjModel, data: mujoco.MjData, geom: int, T_wf: pin.SE3 | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper corner of the exact bounding box of a geom [m].

    Args:
        model: The compiled model.
        data: Its data, with the poses of geoms.
        geom: Id of the geom.
        T_wf: The frame along whose axes the box is; default: the world.
    """
    kind, size = _Geom(int(model.geom_type[geom])), model.geom_size[geom]
    position, rotation = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    if T_wf is not None:
        rotation = T_wf.rotation.T @ rotation
        position = (position - T_wf.translation) @ T_wf.rotation
    if kind == _Geom.mjGEOM_MESH:
        mesh = int(model.geom_dataid[geom])
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = model.mesh_vert[first : first + count] @ rotation.T + position
        return points.min(axis=0), points.max(axis=0)
    if kind == _Geom.mjGEOM_SPHERE:
        half = np.full(3, size[0])
    elif kind == _Geom.mjGEOM_CAPSULE:
        half = size[0] + np.abs(rotation[:, 2]) * size[1]
    elif kind == _Geom.mjGEOM_CYLINDER:
        half = np.hypot(rotation[:, 0], rotation[:, 1]) * size[0]
        half = half + np.abs(rotation[:, 2]) * size[1]
    elif kind == _Geom.mjGEOM_ELLIPSOID:
        half = np.linalg.norm(rotation * size, axis=1)
    else:  # boxes, and geoms that MuJoCo bounds by boxes
        centre, half_local = model.geom_aabb[geom, :3], model.geom_aabb[geom, 3:]
        position = position + rotation @ centre
        half = np.abs(rotation) @ half_local
    return position - half, position + half
