"""Collision detection in a scratch copy of the model."""

import mujoco
import numpy as np
import pytest

from bt_manip.collision.collision_model import CollisionModel, collidable_pairs, pair_margins
from tests.collision.scenes import arm_among_obstacles


def test_collidable_pairs_are_those_that_mujoco_finds_contacts_of(rng):
    _, cell = arm_among_obstacles(rng, holding=True)
    model = cell.model
    pairs = collidable_pairs(model)
    model.geom_margin[:] = model.body_margin[:] = 5.0  # [m] everything is near
    data = mujoco.MjData(model)
    data.qpos[:] = cell.data.qpos
    mujoco.mj_kinematics(model, data)
    mujoco.mj_collision(model, data)
    found = np.zeros_like(pairs)
    found[data.contact.geom[:, 0], data.contact.geom[:, 1]] = True
    found |= found.T
    assert not (found & ~pairs).any()
    plane = model.geom_type == int(mujoco.mjtGeom.mjGEOM_PLANE)
    box = model.geom_type == int(mujoco.mjtGeom.mjGEOM_BOX)
    missing = pairs & ~found & ~(box[:, np.newaxis] & box)  # none of boxes far apart
    fixed = model.body_dofnum[model.body_weldid[model.geom_bodyid]] == 0
    both_fixed = fixed[:, np.newaxis] & fixed  # not relevant
    assert not (missing & ~both_fixed & ~plane & ~plane[:, np.newaxis]).any()
    assert found.sum() > 100


def test_with_more_sets_of_partners_than_bits_no_pair_is_missed():
    spheres = "".join(
        f'<body pos="{0.01 * i} 0 0"><freejoint/><geom size=".01"/></body>' for i in range(40)
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{spheres}</worldbody></mujoco>")
    chain = np.eye(40, k=1, dtype=bool) | np.eye(40, k=-1, dtype=bool)
    scratch = CollisionModel(model, 0.0)
    scratch.restrict_to(np.zeros_like(chain))
    scratch.restrict_to(chain)
    scratch.collide()
    first, second, _ = scratch.contacts
    found = set(zip(first.tolist(), second.tolist(), strict=True))
    assert found >= {(i, i + 1) for i in range(39)}


def test_distances_are_those_to_the_margins_where_the_physics_begins_to_push():
    bodies = "".join(
        f'<body pos="{0.21 * i} 0 0"><freejoint/><geom name="{i}" size=".1" margin="{m}"/></body>'
        for i, m in enumerate((0.002, 0.003, 0.0))
    )
    rest = '</worldbody><contact><pair geom1="1" geom2="2" margin=".004"/></contact></mujoco>'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}{rest}")
    assert pair_margins(model)[[0, 1, 0], [1, 2, 2]] == pytest.approx([0.005, 0.004, 0.002])
    scratch = CollisionModel(model, 0.006)
    for by in (0.0, 0.003):
        scratch.inflate(np.arange(4) == 2, by)
        scratch.collide()
        found = np.array(scratch.contacts)[:, np.argsort(scratch.contacts.first)]
        assert found == pytest.approx(np.array([[0, 1], [1, 2], [0.01 - 0.005 - by, 0.006]]))
