"""The convex solids that an object collides as."""

from dataclasses import dataclass
from functools import cached_property

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell
from bt_manip.exceptions import MotionError

from .polyhedron import Polyhedron, bounded_by, hull_of_mesh, triangles_of

_KINDS = {
    int(mujoco.mjtGeom.mjGEOM_BOX): "box",
    int(mujoco.mjtGeom.mjGEOM_SPHERE): "sphere",
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): "cylinder",
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): "capsule",
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): "ellipsoid",
    int(mujoco.mjtGeom.mjGEOM_MESH): "mesh",
}


@dataclass(frozen=True, eq=False)
class Solid:
    """One convex solid of an object; a mesh stands for its convex hull, as in the physics.

    Attributes:
        kind: ``box``, ``sphere``, ``cylinder``, ``capsule``, ``ellipsoid`` or ``mesh``.
        size: Half lengths or radii as MuJoCo has them [m].  # (3,)
        T_os: Its pose in the object.
        friction: Sliding friction [-].
        hull: Triangles of a mesh's convex hull, in the frame of the solid [m].  # (n, 3, 3)
    """

    kind: str
    size: np.ndarray
    T_os: pin.SE3
    friction: float
    hull: np.ndarray | None = None

    @cached_property
    def polyhedron(self) -> Polyhedron:
        """The solid bounded by planes, in the object's frame."""
        triangles = triangles_of(self.kind, self.size) if self.hull is None else self.hull
        return bounded_by(triangles @ self.T_os.rotation.T + self.T_os.translation)

    def reach(self, directions: np.ndarray) -> np.ndarray:
        """Give how far it reaches in directions of the object's frame, from the origin [m].

        Args:
            directions: Unit.  # (n, 3)
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
    """List the convex solids of an entity that can touch something.

    Raises:
        CellError: When there is no such entity.
        MotionError: When nothing of it can be gripped.
    """
    cell.find(name)
    model, data = cell.model, cell.data
    root = cell.body_id(name)
    T_wo = cell.pose(name)
    touches = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    mine = touches & (model.body_rootid[model.geom_bodyid] == model.body_rootid[root])
    mine &= model.geom_bodyid >= root
    solids = []
    for geom in np.flatnonzero(mine):
        kind = _KINDS.get(int(model.geom_type[geom]))
        if kind is None:
            continue
        mesh = int(model.geom_dataid[geom])
        hull = hull_of_mesh(model, mesh) if kind == "mesh" else None
        T_wg = pin.SE3(data.geom_xmat[geom].reshape(3, 3).copy(), data.geom_xpos[geom].copy())
        friction = float(model.geom_friction[geom, 0])
        size = np.array(model.geom_size[geom])
        solids.append(Solid(kind, size, T_wo.actInv(T_wg), friction, hull))
    if not solids:
        raise MotionError(f"'{name}' has no shape that fingers could grip", reason="grasp")
    return solids
