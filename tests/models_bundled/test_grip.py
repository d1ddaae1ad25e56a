from math import pi

import mujoco
import numpy as np

HOME = np.array([0, -pi / 4, 0, -3 * pi / 4, 0, pi / 2, pi / 4])
FORCE = 50.0  # [N] of each finger


def test_a_cube_held_with_50_n_neither_sinks_in_nor_creeps(scene):
    physics = scene(panda=(0, 0, 0), cube=(0, 0, 0))
    model, data = physics.model.ptr, physics.data.ptr
    data.qpos[:9] = (*HOME, 0.0252, 0.0252)
    mujoco.mj_forward(model, data)
    tool, cube = data.site("panda/tool"), data.body("cube/cube")
    data.qpos[9:12] = tool.xpos
    offsets = []
    for _ in range(1200):
        arm = data.qfrc_bias[:7] + 2000 * (HOME - data.qpos[:7]) - 100 * data.qvel[:7]
        apart = 2500 * (data.qpos[7] - data.qpos[8]) + 50 * (data.qvel[7] - data.qvel[8])
        fingers = data.qfrc_bias[7:9] - min(FORCE, 500 * data.time)
        data.ctrl[:] = (*arm, *(fingers + (-apart, apart)))
        mujoco.mj_step(model, data)
        offsets.append(tool.xmat.reshape(3, 3).T @ (cube.xpos - tool.xpos))
    normal = {"left": 0.0, "right": 0.0}
    wrench = np.empty(6)
    for k, contact in enumerate(data.contact):
        names = {model.body(model.geom_bodyid[g]).name for g in (contact.geom1, contact.geom2)}
        assert "cube/cube" in names
        mujoco.mj_contactForce(model, data, k, wrench)
        for side in normal:
            normal[side] += wrench[0] * (f"panda/{side}_finger" in names)
        assert contact.dist > -0.5e-3
    np.testing.assert_allclose(list(normal.values()), FORCE, atol=0.5)
    creep = np.linalg.norm(offsets[-1] - offsets[-501]) / 0.5
    assert creep < 0.1e-3


def test_the_pads_meet_when_the_hand_is_closed(panda):
    data = mujoco.MjData(panda)
    data.qpos[:7] = HOME
    data.qpos[7:] = 0.0005
    mujoco.mj_forward(panda, data)
    assert data.ncon == 0
    data.qpos[7:] = 0.0
    mujoco.mj_forward(panda, data)
    pads = {panda.geom(g).name for c in data.contact for g in (c.geom1, c.geom2)}
    assert pads == {"left_finger_pad", "right_finger_pad"}
