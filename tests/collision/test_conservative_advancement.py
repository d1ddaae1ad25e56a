"""What is proven free without a look, held against a look at each configuration."""

from collections.abc import Sequence
from functools import cache

import mujoco
import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip import spatial
from bt_manip.cell import Cell, objects
from bt_manip.collision import CollisionWorld, FreeSpace
from bt_manip.collision.arm_motion import ArmMotion, part_of_body
from bt_manip.collision.enclosing_boxes import Boxes, apart
from bt_manip.collision.geom_pairs import comparable
from bt_manip.planning import discretize_segment
from bt_manip.plugins import load_plugins
from bt_manip.robots import Robot, RobotDescription, panda
from tests.measuring.scenes import SCALES
from tests.robot_fixtures import Box

HOME = np.array(panda().home)


class Stone(composer.Entity):
    """A mesh with many corners; its origin is in its middle."""

    def _build(self, rng: np.random.Generator, name: str = "stone") -> None:
        corners = rng.normal(size=(40, 3))
        corners *= 0.08 / np.linalg.norm(corners, axis=1, keepdims=True)
        self._root = mjcf.RootElement(model=name)
        self._root.asset.add("mesh", name="hull", vertex=corners.ravel().tolist())
        self._root.worldbody.add("geom", name="hull", type="mesh", mesh="hull")

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        return self._root


def among_many(
    rng: np.random.Generator, *, holding: bool = False, arm: RobotDescription | None = None
) -> tuple[CollisionWorld, Cell]:
    """An arm on the floor between boxes, a mesh and balls, with or without a cube in its hand."""
    cell, robot = Cell(), Robot(arm or panda())
    cell.add(robot, spatial.pose((0.0, 0.0, 0.3)), free=False)
    robot.set_configuration(np.array(robot.description.home))
    if arm is None:
        robot.mj_data.qpos[robot.gripper_qpos_adr] = 0.025 - 1e-4
    mujoco.mj_forward(cell.model, cell.data)
    things: Sequence[composer.Entity] = (
        Box((0.3, 0.2, 0.3)), Box((0.1, 0.5, 0.02)), Stone(rng), objects.Cube(), Stone(rng)
    )  # fmt: skip
    with cell.editing():
        for i, thing in enumerate(things):
            angle = -2.0 + i
            at = (0.6 * np.cos(angle), 0.6 * np.sin(angle), rng.uniform(0.1, 0.6))
            pose = spatial.pose(at, rng.normal(size=4))
            cell.add(thing, pose, name=f"thing_{i}", free=False, overlap=np.inf)
        if holding:
            T_to = spatial.pose((0.0, 0.0, 0.015))
            cell.add(objects.Cube(), robot.tool_pose * T_to, name="held")
    return CollisionWorld(robot, robot.make_model()), cell


def compare(
    world: CollisionWorld,
    motions: int,
    rng: np.random.Generator,
    home: np.ndarray = HOME,
    limits: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[int, int, int]:
    """Count the configurations of random motions: all, the free ones, those proven to be free."""
    limits = limits or panda_limits()
    count = free = sure = 0
    for k in range(motions):
        start = rng.uniform(*limits) if k % 2 else home
        way = rng.uniform(-1.0, 1.0, len(home)) * rng.uniform(0.1, 1.5)
        end = np.clip(start + way, *limits)
        path = np.vstack([start, discretize_segment(start, end, 2e-3)])
        space = FreeSpace(world, start, clearance=(0.0, 4e-3, 8e-3)[k % 3])
        proven = space.proven(path)
        found = np.array([space.keeps_distance(q) for q in path])
        assert not (proven & ~found).any(), (start, end)
        count, free, sure = count + len(path), free + found.sum(), sure + proven.sum()
    return count, free, sure


@cache
def panda_limits() -> tuple[np.ndarray, np.ndarray]:
    limits = Robot(panda()).limits
    return limits.lower, limits.upper


@pytest.mark.parametrize("holding", [False, True])
def test_what_is_proven_free_is_found_free_by_a_look_at_each(rng, holding):
    world, _ = among_many(rng, holding=holding)
    assert (world.held == "held") == holding
    count, free, sure = compare(world, 24, rng)
    assert free < 0.95 * count  # some of it touches something
    assert sure > 0.7 * free


def test_things_that_are_taken_for_thicker_are_for_the_proof_too(rng):
    world, cell = among_many(rng)
    bodies = np.zeros(cell.model.nbody, dtype=bool)
    bodies[[cell.body_id(f"thing_{i}") for i in range(5)]] = True
    free = []
    for by in (0.0, 0.03):
        world._near.widen(bodies, by)
        _, found, sure = compare(world, 12, np.random.default_rng(7))
        assert sure > 0.6 * found
        free.append(found)
    assert free[1] < free[0]


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(12))
def test_no_look_contradicts_what_is_proven_in_many_scenes(seed):
    rng = np.random.default_rng(seed)
    world, _ = among_many(rng, holding=bool(seed % 2))
    compare(world, 300, rng)


@pytest.mark.soak
@pytest.mark.parametrize("name", SCALES)
def test_no_look_contradicts_what_is_proven_of_arms_of_meshes(name, menagerie, monkeypatch):
    pytest.importorskip("bt_manip_menagerie")
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    arm = load_plugins().parts.robots.get(name)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        world, _ = among_many(rng, arm=arm)
        limits = Robot(arm).limits
        inside = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
        _, free, sure = compare(world, 60, rng, np.array(arm.home), inside)
        assert sure > 0.6 * free


def test_few_looks_do_where_nothing_is_near(walled, monkeypatch):
    space = FreeSpace(walled.world, HOME)
    path = discretize_segment(HOME, HOME + [0.4, 0.1, -0.1, 0.2, 0.0, 0.1, 0.3], 2e-3)
    looks = []
    look = type(walled.world._near).look
    monkeypatch.setattr(
        type(walled.world._near), "look", lambda *args: looks.append(1) or look(*args)
    )
    assert space.path_is_free(path)
    assert len(looks) < len(path) / 10


def test_the_first_configuration_that_is_not_free_is_found_as_without_a_proof(walled):
    end = walled.ik.solve(walled.left, HOME).q
    path = discretize_segment(end, walled.ik.solve(walled.right, end).q, 2e-3)
    space = FreeSpace(walled.world, end)
    first = space.first_blocked(path)
    assert first == next(i for i, q in enumerate(path) if not space.is_free(q))
    assert 10 < first < len(path) - 10


def test_no_point_of_the_arm_moves_farther_than_the_bound(rng):
    _, cell = among_many(rng)
    model = cell.model
    names = [f"panda/joint{i}" for i in range(1, 8)]
    joints = np.array([model.joint(name).id for name in names])
    adr, data = model.jnt_qposadr[joints], mujoco.MjData(model)
    part = part_of_body(model, joints)[model.geom_bodyid]
    mujoco.mj_kinematics(model, data)
    motion = ArmMotion(model, data, joints, part)
    geoms = np.flatnonzero(part)
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
        q = rng.uniform(*panda_limits())
        turned = rng.uniform(-size, size, (5, 7))
        before = points(q)
        ways = motion.ways(motion.stands([motion.stand(data)]), turned[np.newaxis])[0]
        for way, turn in zip(ways, turned, strict=True):
            moved = np.where(inside, np.linalg.norm(points(q + turn) - before, axis=-1), 0.0)
            longest = np.array([moved[part[geoms] == k].max(initial=0.0) for k in range(1, 8)])
            assert (longest <= way + 1e-12).all()
            shares.append(longest[-1] / way[-1])
    assert np.mean(shares[:50]) > 0.5  # not much farther either, on short ways


def test_parts_see_each_other_move_no_farther_than_the_bound(rng):
    _, cell = among_many(rng)
    model = cell.model
    joints = np.array([model.joint(f"panda/joint{i}").id for i in range(1, 8)])
    adr, data = model.jnt_qposadr[joints], mujoco.MjData(model)
    of_body = part_of_body(model, joints)
    part = of_body[model.geom_bodyid]
    mujoco.mj_kinematics(model, data)
    motion = ArmMotion(model, data, joints, part)

    def seen(q, base):
        """Middles of the geoms from a body."""
        data.qpos[adr] = q
        mujoco.mj_kinematics(model, data)
        return (data.geom_xpos - data.xpos[base]) @ data.xmat[base].reshape(3, 3)

    for size in np.geomspace(1e-2, 1.0, 20):
        q, turned = rng.uniform(*panda_limits()), rng.uniform(-size, size, 7)
        bound = motion.ways_apart(np.abs(turned)[np.newaxis])[0]
        for before in range(1, 7):
            base = int(model.jnt_bodyid[joints[before - 1]])
            moved = np.linalg.norm(seen(q + turned, base) - seen(q, base), axis=1)
            for later in range(before + 1, 8):
                assert moved[part == later].max() <= bound[before - 1, later - 1] + 1e-12


def test_compared_are_the_pairs_that_mujoco_finds_contacts_of(rng):
    _, cell = among_many(rng, holding=True)
    model = cell.model
    pairs = comparable(model)
    model.geom_margin[:] = model.body_margin[:] = 5.0  # [m] all is near
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
    missing = pairs & ~found & ~(box[:, np.newaxis] & box)  # it sees none of boxes far apart
    fixed = model.body_dofnum[model.body_weldid[model.geom_bodyid]] == 0
    both_fixed = fixed[:, np.newaxis] & fixed  # nobody asks for these
    assert not (missing & ~both_fixed & ~plane & ~plane[:, np.newaxis]).any()
    assert found.sum() > 100


def test_boxes_are_at_least_as_far_apart_as_the_bound(rng):
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody>
        <body><freejoint/><geom type="box" size=".05 .03 .1"/></body>
        <body><freejoint/><geom type="box" size=".02 .2 .04"/></body>
        </worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    shares = []
    for _ in range(500):
        data.qpos[:] = rng.normal(size=14) * np.tile([0.2, 0.2, 0.2, 1.0, 1.0, 1.0, 1.0], 2)
        mujoco.mj_kinematics(model, data)
        boxes = [
            Boxes(data.geom_xpos[[i]], data.geom_xmat[[i]].reshape(1, 3, 3), model.geom_size[[i]])
            for i in range(2)
        ]
        distance = mujoco.mj_geomDistance(model, data, 0, 1, 5.0, None)
        bound = apart(*boxes, np.array([5.0]))[0]
        assert bound <= distance + 1e-6
        if distance > 0.05:
            shares.append(bound / distance)
    assert np.mean(shares) > 0.85


def test_boxes_face_to_face_are_as_far_apart_as_their_faces():
    flat = Boxes(np.array([[0.0, 0.0, 0.0]]), np.eye(3)[None], np.array([[1.0, 1.0, 0.1]]))
    small = Boxes(np.array([[0.5, 0.9, 0.25]]), np.eye(3)[None], np.array([[0.1, 0.1, 0.1]]))
    assert apart(flat, small, np.ones(1)) == pytest.approx([0.05])
    assert apart(small, flat, np.ones(1)) == pytest.approx([0.05])


def test_joints_that_slide_or_branch_are_left_to_looks():
    def parts(joint: str, second: str) -> np.ndarray | None:
        model = mujoco.MjModel.from_xml_string(
            f"""<mujoco><worldbody><body><joint name="a" {joint}/><geom size=".1"/>
            {second.format('<body><joint name="b"/><geom size=".1"/></body>')}
            </worldbody></mujoco>"""
        )
        return part_of_body(model, np.array([0, 1]))

    assert parts('type="hinge"', "{}</body>").tolist() == [0, 1, 2]
    assert parts('type="slide"', "{}</body>") is None
    assert parts('type="hinge"', "</body>{}") is None
