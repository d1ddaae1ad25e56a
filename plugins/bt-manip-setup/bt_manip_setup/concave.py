"""Bodies of a gripper whose meshes are concave."""

import mujoco
import numpy as np
import trimesh

from bt_manip.cell import literal_name
from bt_manip.grippers import collision_geoms_of

from .finger_travel.bench import ancestors

_CONVEX = 0.9  # least volume of a mesh that its hull stands for, relative to the hull's
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)


def concave_bodies(model: mujoco.MjModel, last_joint: str) -> tuple[str, ...]:
    """Return the names of bodies from an arm's last link on that collide by concave meshes.

    Args:
        model: The robot, compiled alone.
        last_joint: Full name of the arm's last joint.

    Returns:
        Names in `RobotDescription.convex_parts`.
    """
    last, found = int(model.joint(last_joint).bodyid[0]), []
    for body in range(model.nbody):
        if last in ancestors(model, body) and any(
            _is_concave(model, int(model.geom_dataid[geom]))
            for geom in collision_geoms_of(model, body)
            if int(model.geom_type[geom]) == _MESH
        ):
            found.append(literal_name(model.body(body).name))
    return tuple(found)


def _is_concave(model: mujoco.MjModel, mesh: int) -> bool:
    """Return whether a mesh fills less than its hull."""
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    solid = trimesh.Trimesh(vertices, faces)
    return bool(np.abs(solid.volume) < _CONVEX * solid.convex_hull.volume)
