"""The shells in the Panda's file are those that the generator writes."""

import mujoco
import numpy as np

from tools import panda_shells as generator


def test_the_file_holds_and_uses_what_the_generator_writes(panda):
    found = generator.BLOCK.search(generator.PANDA.read_text())
    assert found is not None
    assert found[2] == generator.block()
    used = {panda.mesh(i).name for i in panda.geom_dataid if i >= 0}
    assert used == set(generator.SHELLS)


def gap(panda: mujoco.MjModel, data: mujoco.MjData, point: np.ndarray, geom: int) -> float:
    """Return how far a point is outside a capsule or a box [m]."""
    local = data.geom_xmat[geom].reshape(3, 3).T @ (point - data.geom_xpos[geom])
    size = panda.geom_size[geom]
    if panda.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
        local[2] -= np.clip(local[2], -size[1], size[1])
        return float(np.linalg.norm(local) - size[0])
    return float(np.linalg.norm(np.maximum(np.abs(local) - size, 0)))


def test_what_is_seen_of_the_arm_is_never_far_from_what_collides(panda):
    """At most 3 cm; the foot of link0 alone reaches further."""
    data = mujoco.MjData(panda)
    data.qpos = (0, -0.785, 0, -2.356, 0, 1.571, 0.785, 0.04, 0.04)
    mujoco.mj_kinematics(panda, data)
    solid = np.flatnonzero(panda.geom_group == 3)
    for geom in np.flatnonzero(panda.geom_type == mujoco.mjtGeom.mjGEOM_MESH):
        if panda.geom_bodyid[geom] == panda.body("link0").id:
            continue
        mesh = panda.mesh(panda.geom_dataid[geom])
        vertices = panda.mesh_vert[mesh.vertadr[0] :][: mesh.vertnum[0]]
        for vertex in vertices[::5]:
            point = data.geom_xpos[geom] + data.geom_xmat[geom].reshape(3, 3) @ vertex
            assert min(gap(panda, data, point, other) for other in solid) < 0.03, mesh.name
