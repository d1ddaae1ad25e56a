"""Links of a gripper: contacts with each other, and concave meshes."""

import copy

import mujoco
import numpy as np
import trimesh

from bt_manip.cell import literal_name
from bt_manip.collision import moved_bodies
from bt_manip.grippers import collision_geoms_of
from bt_manip.robots import Robot

_NEAR = 1e-3  # [m] distance of links that may touch when the mechanism bends under a grip
_OPENINGS = 21  # examined openings, from closed to open
_CONVEX = 0.9  # least volume of a mesh that its hull stands for, relative to the hull's
_MESH = int(mujoco.mjtGeom.mjGEOM_MESH)


def touching_links(robot: Robot) -> list[tuple[str, str]]:
    """Return the pairs of a gripper's links that touch at some opening, except its two fingers.

    Links are the bodies from the arm's last link on. As their makers built them they do not
    obstruct each other, but shapes that stand for them in a model do, such as convex hulls.
    """
    assert robot.gripper is not None
    model, prefix = copy.copy(robot.mj_model), robot.mjcf_model.full_identifier
    model.geom_margin[:] = 0.5 * _NEAR  # of both geoms together
    names = {
        body: literal_name(model.body(body).name.removeprefix(prefix))
        for body in np.flatnonzero(moved_bodies(model, robot.dof_adr[-1:])).tolist()
    }
    data, found, fingers = mujoco.MjData(model), set(), set(robot.gripper.contact_body_ids)
    data.qpos[:] = robot.mj_data.qpos
    for share in np.linspace(0.0, 1.0, _OPENINGS):
        robot.gripper.set_opening(data.qpos, float(share))
        mujoco.mj_kinematics(model, data)
        mujoco.mj_collision(model, data)
        bodies = model.geom_bodyid[data.contact.geom].reshape(-1, 2)
        found |= {tuple(sorted(pair)) for pair in bodies.tolist() if {*pair} != fingers}
    return sorted({(names[a], names[b]) for a, b in found if names.keys() >= {a, b}})


def concave_bodies(model: mujoco.MjModel, last_joint: str) -> tuple[str, ...]:
    """Return the names of bodies beyond an arm's last joint that collide by concave meshes."""
    links = np.flatnonzero(moved_bodies(model, model.joint(last_joint).dofadr)).tolist()
    return tuple(
        literal_name(model.body(body).name)
        for body in links
        if any(
            _is_concave(model, int(model.geom_dataid[geom]))
            for geom in collision_geoms_of(model, body)
            if int(model.geom_type[geom]) == _MESH
        )
    )


def _is_concave(model: mujoco.MjModel, mesh: int) -> bool:
    """Return whether a mesh fills less than its hull."""
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    faces = model.mesh_face[model.mesh_faceadr[mesh] :][: model.mesh_facenum[mesh]]
    solid = trimesh.Trimesh(vertices, faces)
    return bool(np.abs(solid.volume) < _CONVEX * solid.convex_hull.volume)
