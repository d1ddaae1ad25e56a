"""What of the Panda touches what."""

from collections import Counter
from itertools import combinations
from math import pi

import mujoco
import numpy as np
import pytest

OPEN = (0.04, 0.04)
HOME = (0, -pi / 4, 0, -3 * pi / 4, 0, pi / 2, pi / 4)

# Tool pointing down over the cubes' area (grasp, hover) and over the basket, fingers open.
PICKING = {
    "home": HOME,
    "grasp near right": (-0.7885, 0.3612, 0.0022, -2.6073, -0.0045, 2.9685, 0.0033),
    "grasp near left": (0.7858, 0.3612, -0.0003, -2.6073, 0.0006, 2.9685, 0.8703),
    "grasp far right": (-0.5932, 0.6193, 0.0486, -2.0619, -0.0633, 2.6798, 0.9884),
    "grasp far left": (0.4603, 0.6203, 0.0737, -2.0614, -0.0960, 2.6786, 1.0916),
    "grasp nearest": (0.0064, 0.2218, 0.0328, -2.9713, 0.1395, 3.1935, -0.8155),
    "hover": (0.1370, -0.5081, -0.1127, -2.3224, -0.0565, 1.8166, 0.3376),
    "hover far left": (0.4204, 0.0641, 0.1241, -1.7385, -0.0081, 1.8021, 1.3315),
    "drop": (0.0, 0.9033, 0.0, -0.8878, 0.0, 1.7911, 0.7854),
}

EXCLUDED = {
    ("link0", "link1"), ("link1", "link2"), ("link2", "link3"), ("link3", "link4"),
    ("link4", "link5"), ("link5", "link6"), ("link6", "link7"), ("link7", "hand"),
    ("hand", "left_finger"), ("hand", "right_finger"),
    ("link1", "link3"), ("link5", "link7"),
}  # fmt: skip


def touching(model: mujoco.MjModel, data: mujoco.MjData) -> set[tuple[str, str]]:
    """Return the pairs of bodies in contact, in the model's order."""
    pairs = {tuple(sorted(model.geom_bodyid[[c.geom1, c.geom2]])) for c in data.contact}
    return {(model.body(first).name, model.body(second).name) for first, second in pairs}


def test_excluded_pairs_are_neighbours_and_the_two_that_the_capsules_need(panda):
    signatures = panda.exclude_signature
    pairs = {(panda.body(s >> 16).name, panda.body(s & 0xFFFF).name) for s in signatures.tolist()}
    assert pairs == EXCLUDED
    assert len(signatures) == len(EXCLUDED)


def test_configurations_of_work_are_free_of_contacts(panda):
    data = mujoco.MjData(panda)
    for name, q in PICKING.items():
        data.qpos = (*q, *OPEN)
        mujoco.mj_forward(panda, data)
        assert touching(panda, data) == set(), name


def test_links_are_mostly_apart_and_no_pair_always_touches(panda):
    rng = np.random.default_rng(11)
    data = mujoco.MjData(panda)
    lower, upper = panda.jnt_range.T
    counts: Counter[tuple[str, str]] = Counter()
    n, free = 1000, 0
    for _ in range(n):
        data.qpos = rng.uniform(lower, upper)
        mujoco.mj_kinematics(panda, data)
        mujoco.mj_comPos(panda, data)
        mujoco.mj_collision(panda, data)
        pairs = touching(panda, data)
        counts.update(pairs)
        free += not pairs
    assert free > 0.9 * n
    assert max(counts.values()) < 0.05 * n
    assert ("link5", "hand") in counts  # the arm can hit itself, and it shows


def test_every_body_can_touch_every_body_that_is_not_excluded(panda):
    """Two bodies laid over each other touch, unless the pair is on the list."""
    names = [panda.body(i).name for i in range(1, panda.nbody)]
    for pair in combinations(names, 2):
        spec = mujoco.MjSpec()
        for name in pair:
            body = spec.worldbody.add_body(name=name)
            body.add_freejoint()
            geoms = np.flatnonzero(
                (panda.geom_bodyid == panda.body(name).id) & (panda.geom_group == 3)
            )
            assert len(geoms) > 0
            for g in geoms:
                body.add_geom(
                    type=panda.geom_type[g], size=panda.geom_size[g], density=1000.0,
                    contype=panda.geom_contype[g], conaffinity=panda.geom_conaffinity[g],
                )  # fmt: skip
        model = spec.compile()
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        assert data.ncon > 0, pair


def lowest_point(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> np.ndarray:
    """Return the lowest point of a capsule, or of a box that stands upright (a point below it)."""
    centre, axes = data.geom_xpos[geom], data.geom_xmat[geom].reshape(3, 3)
    if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CAPSULE:
        radius, half, _ = model.geom_size[geom]
        return centre - half * np.sign(axes[2, 2]) * axes[:, 2] - (0, 0, radius)
    return centre - (0, 0, np.abs(axes[2]) @ model.geom_size[geom])


@pytest.mark.parametrize("other", ["cube", "table", "basket"])
def test_every_link_touches_an_object_that_is_pushed_against_it_from_below(scene, other):
    physics = scene(free=(other,), panda=(0, 0, 0), **{other: (0, 0, 0)})
    model, data = physics.model.ptr, physics.data.ptr
    theirs = model.body(f"{other}/{other}").id
    shape = np.flatnonzero((model.geom_bodyid == theirs) & (model.geom_group == 3))[0]
    for name in [f"link{i}" for i in range(1, 8)] + ["hand", "left_finger", "right_finger"]:
        ours = model.body(f"panda/{name}").id
        target = np.flatnonzero((model.geom_bodyid == ours) & (model.geom_group == 3))[0]
        data.qpos[:9] = (*HOME, *OPEN)
        mujoco.mj_kinematics(model, data)
        top = data.geom_xpos[shape] + (0, 0, model.geom_size[shape][2])
        data.qpos[9:12] += lowest_point(model, data, target) - top + (0, 0, 0.005)
        mujoco.mj_forward(model, data)
        assert (f"panda/{name}", f"{other}/{other}") in touching(model, data)


def test_the_other_links_stay_clear_of_the_plane_that_it_stands_on(panda):
    data = mujoco.MjData(panda)
    for q1 in np.linspace(-2.8, 2.8, 15):
        data.qpos = (q1, *HOME[1:], *OPEN)
        mujoco.mj_kinematics(panda, data)
        for g in np.flatnonzero(panda.geom_group == 3):
            if panda.geom_bodyid[g] > panda.body("link0").id:
                reach = panda.geom_rbound[g]
                if panda.geom_type[g] == mujoco.mjtGeom.mjGEOM_CAPSULE:
                    radius, half = panda.geom_size[g][:2]
                    reach = radius + half * abs(data.geom_xmat[g][8])
                assert data.geom_xpos[g][2] - reach > 0.009
