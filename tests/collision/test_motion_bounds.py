"""Bounds of the displacement of an arm's links."""

import mujoco
import numpy as np

from bt_manip.collision.motion_bounds import MotionBounds, link_of_body
from tests.collision.scenes import arm_among_obstacles


def panda_chain(rng) -> tuple[mujoco.MjModel, np.ndarray, tuple[np.ndarray, np.ndarray]]:
    """Return a cell with a Panda, the ids of its joints, and their limits."""
    model = arm_among_obstacles(rng)[1].model
    joints = np.array([model.joint(f"panda/joint{i}").id for i in range(1, 8)])
    lower, upper = model.jnt_range[joints].T
    return model, joints, (lower, upper)


def test_no_point_of_the_arm_is_displaced_by_more_than_the_bound(rng):
    model, joints, joint_limits = panda_chain(rng)
    adr, data = model.jnt_qposadr[joints], mujoco.MjData(model)
    link = link_of_body(model, joints)[model.geom_bodyid]
    mujoco.mj_kinematics(model, data)
    bounds = MotionBounds(model, data, joints, link)
    geoms = np.flatnonzero(link)
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
    at_geom = model.geom_aabb[geoms, None, :3] + corners * model.geom_aabb[geoms, None, 3:]
    inside = np.linalg.norm(at_geom, axis=-1) <= model.geom_rbound[geoms, None]

    def points(q):
        data.qpos[adr] = q
        mujoco.mj_kinematics(model, data)
        rotation = data.geom_xmat[geoms].reshape(-1, 3, 3)
        return data.geom_xpos[geoms, None] + at_geom @ rotation.transpose(0, 2, 1)

    shares = []
    for size in np.geomspace(1e-3, 1.0, 40):
        q = rng.uniform(*joint_limits)
        dq = rng.uniform(-size, size, (5, 7))
        before = points(q)
        limits = bounds.displacement([bounds.frames(data)], dq[np.newaxis])[0]
        for limit, step in zip(limits, dq, strict=True):
            moved = np.where(inside, np.linalg.norm(points(q + step) - before, axis=-1), 0.0)
            longest = np.array([moved[link[geoms] == k].max(initial=0.0) for k in range(1, 8)])
            assert (longest <= limit + 1e-12).all()
            shares.append(longest[-1] / limit[-1])
    assert np.mean(shares[:50]) > 0.5  # the bound is tight for short motions


def test_no_link_is_displaced_relative_to_another_by_more_than_the_bound(rng):
    model, joints, joint_limits = panda_chain(rng)
    adr, data = model.jnt_qposadr[joints], mujoco.MjData(model)
    link = link_of_body(model, joints)[model.geom_bodyid]
    mujoco.mj_kinematics(model, data)
    bounds = MotionBounds(model, data, joints, link)

    def positions(q, base):
        """Positions of the geoms in the frame of a body."""
        data.qpos[adr] = q
        mujoco.mj_kinematics(model, data)
        return (data.geom_xpos - data.xpos[base]) @ data.xmat[base].reshape(3, 3)

    for size in np.geomspace(1e-2, 1.0, 20):
        q, dq = rng.uniform(*joint_limits), rng.uniform(-size, size, 7)
        bound = bounds.relative_displacement(np.abs(dq)[np.newaxis])[0]
        for before in range(1, 7):
            base = int(model.jnt_bodyid[joints[before - 1]])
            moved = np.linalg.norm(positions(q + dq, base) - positions(q, base), axis=1)
            for later in range(before + 1, 8):
                assert moved[link == later].max() <= bound[before - 1, later - 1] + 1e-12


def test_arms_that_are_not_a_chain_of_hinges_have_no_links():
    def links(joint: str, second: str) -> np.ndarray | None:
        model = mujoco.MjModel.from_xml_string(
            f"""<mujoco><worldbody><body><joint name="a" {joint}/><geom size=".1"/>
            {second.format('<body><joint name="b"/><geom size=".1"/></body>')}
            </worldbody></mujoco>"""
        )
        return link_of_body(model, np.array([0, 1]))

    assert links('type="hinge"', "{}</body>").tolist() == [0, 1, 2]
    assert links('type="slide"', "{}</body>") is None
    assert links('type="hinge"', "</body>{}") is None
