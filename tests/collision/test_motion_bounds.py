"""Bounds of the displacement of an arm's links."""

import mujoco
import numpy as np
import pytest

from bt_manip.collision.motion_bounds import MotionBounds, link_of_body
from tests.collision.scenes import arm_among_obstacles


def test_no_point_of_the_arm_is_displaced_by_more_than_the_bound(rng):
    model = arm_among_obstacles(rng)[1].model
    joints = np.array([model.joint(f"panda/joint{i}").id for i in range(1, 8)])
    data, link = mujoco.MjData(model), link_of_body(model, joints)[model.geom_bodyid]
    mujoco.mj_kinematics(model, data)
    bounds = MotionBounds(model, data, joints, link)
    geoms = np.flatnonzero(link)
    corners = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T
    at_geom = model.geom_aabb[geoms, None, :3] + corners * model.geom_aabb[geoms, None, 3:]
    inside = np.linalg.norm(at_geom, axis=-1) <= model.geom_rbound[geoms, None]

    def points(q):
        data.qpos[model.jnt_qposadr[joints]] = q
        mujoco.mj_kinematics(model, data)
        rotation = data.geom_xmat[geoms].reshape(-1, 3, 3)
        return data.geom_xpos[geoms, None] + at_geom @ rotation.transpose(0, 2, 1)

    shares = []
    for size in np.geomspace(1e-3, 1.0, 40):
        q = rng.uniform(*model.jnt_range[joints].T)
        dq = rng.uniform(-size, size, (5, 7))
        before = points(q)
        limits = bounds.displacement([bounds.frames(data)], dq[np.newaxis])[0]
        for limit, step in zip(limits, dq, strict=True):
            moved = np.where(inside, np.linalg.norm(points(q + step) - before, axis=-1), 0.0)
            longest = np.array([moved[link[geoms] == k].max(initial=0.0) for k in range(1, 8)])
            assert (longest <= limit + 1e-12).all()
            shares.append(longest[-1] / limit[-1])
    assert np.mean(shares[:50]) > 0.5  # the bound is tight for short motions


def test_the_bounds_of_a_stretched_arm_with_parallel_axes_are_those_of_its_lengths():
    x, r = np.array([0.0, 0.3, 0.7, 0.9]), np.array([0.05, 0.04, 0.03, 0.06])  # joints, spheres
    centre, end = x + 0.12, x + 0.12 + r
    links = "".join(
        f'<body pos="{step} 0 0"><joint/><geom size="{radius}" pos=".12 0 0"/>'
        for step, radius in zip(np.diff(x, prepend=0.0), r, strict=True)
    )
    base = f'<body pos=".3 -.2 .5" quat=".8 .3 -.1 .5">{links}{"</body>" * 5}'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{base}</worldbody></mujoco>")
    data, joints = mujoco.MjData(model), np.arange(4)
    mujoco.mj_kinematics(model, data)
    bounds = MotionBounds(model, data, joints, link_of_body(model, joints)[model.geom_bodyid])
    dq = np.array([0.1, -0.3, 0.25, 0.15])
    found = bounds.displacement([bounds.frames(data)], dq[np.newaxis, np.newaxis])[0, 0]
    relative = bounds.relative_displacement(np.abs(dq)[np.newaxis])[0]
    for k in range(4):
        moved, size = dq[: k + 1], np.abs(dq[: k + 1])
        lever = end[k] - np.maximum.outer(x[: k + 1], x[: k + 1])
        first = abs(moved @ (centre[k] - x[: k + 1])) + r[k] * abs(moved.sum())
        assert found[k] == pytest.approx(first + 0.5 * size @ lever @ size)
        sums = [size[b + 1 :] @ (end[k] - x[b + 1 : k + 1]) for b in range(4)]
        assert relative[:, k] == pytest.approx(sums)


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
