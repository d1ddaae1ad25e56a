"""Conservative advancement, compared with a collision check of each configuration."""

from functools import cache
from itertools import product

import mujoco
import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip import spatial
from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld, FreeSpace
from bt_manip.collision.conservative_advancement import Boxes, box_distance
from bt_manip.grippers import TwoFingerGripper
from bt_manip.planning import discretize_segment
from bt_manip.plugins import load_plugins
from bt_manip.robots import Robot, panda
from tests.collision.scenes import arm_among_obstacles
from tests.measuring.scenes import SCALES

HOME = np.array(panda().home)


def compare(
    world: CollisionWorld,
    motions: int,
    rng: np.random.Generator,
    home: np.ndarray = HOME,
    limits: tuple[np.ndarray, np.ndarray] | None = None,
) -> tuple[int, int, int]:
    """Count configurations of random motions: all, the free ones, and those known to be free."""
    limits = limits or panda_limits()
    count = free = known = 0
    for k in range(motions):
        start = rng.uniform(*limits) if k % 2 else home
        offset = rng.uniform(-1.0, 1.0, len(home)) * rng.uniform(0.1, 1.5)
        end = np.clip(start + offset, *limits)
        path = np.vstack([start, discretize_segment(start, end, 2e-3)])
        space = FreeSpace(world, start, clearance=(0.0, 4e-3, 8e-3)[k % 3])
        known_free = world.known_free(path, space.clearance)
        found = np.array([space.is_free(q) for q in path])
        assert not (known_free & ~found).any(), (start, end)
        count, free, known = count + len(path), free + found.sum(), known + known_free.sum()
    return count, free, known


@cache
def panda_limits() -> tuple[np.ndarray, np.ndarray]:
    limits = Robot(panda()).limits
    return limits.lower, limits.upper


@pytest.mark.parametrize("holding", [False, True])
def test_configurations_known_to_be_free_are_found_free_by_a_check(rng, holding):
    world, _ = arm_among_obstacles(rng, holding=holding)
    assert (world.held == "held") == holding
    count, free, known = compare(world, 14, rng)
    assert free < 0.95 * count  # some are in collision
    assert known > 0.98 * free


def test_inflated_bodies_are_inflated_for_conservative_advancement_too(rng):
    world, cell = arm_among_obstacles(rng)
    bodies = np.zeros(cell.model.nbody, dtype=bool)
    bodies[[cell.body_id(f"obstacle_{i}") for i in range(5)]] = True
    free = []
    for by in (0.0, 0.03):
        world._scratch.inflate(bodies, by)
        _, found, known = compare(world, 6, np.random.default_rng(7))
        assert known > 0.98 * found
        free.append(found)
    assert free[1] < free[0]


def test_planes_are_infinite_for_conservative_advancement_too(rng):
    cell, robot = Cell(), Robot(panda(), gripper=TwoFingerGripper)
    cell.add(robot, free=False)
    facing = spatial.pose((0.5, 0.0, -8.0), (np.sqrt(0.5), 0.0, -np.sqrt(0.5), 0.0))  # towards -x
    wall = mjcf.RootElement(model="wall")
    wall.worldbody.add("geom", type="plane", size=(1.0, 1.0, 0.1))
    with cell.editing():
        cell.add(composer.ModelWrapperEntity(wall), facing, free=False)
    mujoco.mj_forward(cell.model, cell.data)
    world = CollisionWorld(robot, robot.make_model())
    clearance = np.where(world.checked_pairs, 0.0, -np.inf)
    resting = rng.uniform(*panda_limits(), size=(300, 7))
    known = np.array([world.known_free(np.tile(q, (40, 1)), clearance).all() for q in resting])
    free = np.array([not world.collisions(q) for q in resting])
    assert not (known & ~free).any() and 50 < known.sum() > 0.7 * free.sum()


@pytest.mark.soak
@pytest.mark.parametrize("seed", range(12))
def test_no_check_contradicts_it_in_many_scenes(seed):
    rng = np.random.default_rng(seed)
    world, _ = arm_among_obstacles(rng, holding=bool(seed % 2))
    compare(world, 300, rng)


@pytest.mark.soak
@pytest.mark.parametrize("name", SCALES)
def test_no_check_contradicts_it_for_arms_with_meshes(name, menagerie, monkeypatch):
    pytest.importorskip("bt_manip_menagerie")
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    arm = load_plugins().parts.robots.get(name)
    for seed in range(3):
        rng = np.random.default_rng(seed)
        world, _ = arm_among_obstacles(rng, arm=arm)
        inside = Robot(arm).limits.sampling_bounds()
        _, free, known = compare(world, 60, rng, np.array(arm.home), inside)
        assert known > 0.6 * free


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_path_that_leaves_a_collision_in_one_direction_is_not_known_to_be_free(rng, sign):
    world, _ = arm_among_obstacles(rng)
    clearance = np.where(world.checked_pairs, 0.0, -np.inf)
    checked = 0
    for q in rng.uniform(*panda_limits(), size=(1500, 7)):
        end = q + sign * rng.uniform(0.0, 0.3, 7)
        if world.collisions(q) and not world.collisions(end):
            path = np.concatenate([np.linspace(q, end, 25), np.tile(end, (23, 1))])
            assert not world.known_free(path, clearance)[0]
            checked += 1
    assert checked > 30


def test_boxes_nearer_than_the_clearance_corner_to_corner_and_an_error_are_unknown(walled):
    for clearance, gap, known in (
        (0.0, 3e-4, False),
        (0.0, 5e-4, True),
        (2e-3, 3.75e-3, False),
        (2e-3, 4e-3, True),
    ):
        T = spatial.pointing_down((0.5, 0.3, 0.0095 + gap), 0.0)  # the fingers over the table
        path = np.tile(walled.ik.solve(T, HOME).q, (40, 1))
        least = np.where(walled.world.checked_pairs & ~walled.world.self_pairs, clearance, -np.inf)
        assert walled.world.known_free(path, least).all() == known


def test_the_first_blocked_configuration_is_that_of_checking_each(walled):
    end = walled.ik.solve(walled.left, HOME).q
    path = discretize_segment(end, walled.ik.solve(walled.right, end).q, 2e-3)
    space = FreeSpace(walled.world, end)
    first = space.first_blocked(path)
    assert first == next(i for i, q in enumerate(path) if not space.is_free(q))
    assert 10 < first < len(path) - 10


def gap(first: np.ndarray, second: np.ndarray, axis: np.ndarray) -> float:
    """Return the gap of two sets of points along an axis."""
    one, other = first @ axis, second @ axis
    return max(other.min() - one.max(), one.min() - other.max())


def test_the_bound_of_the_distance_of_boxes_is_their_gap_along_a_face_or_from_a_sphere(rng):
    """It is below the distance, and close to it: that of 3 edges has other directions."""
    sizes = np.array([[0.05, 0.03, 0.1], [0.02, 0.2, 0.04]])
    model = mujoco.MjModel.from_xml_string(
        """<mujoco><worldbody>
        <body><freejoint/><geom type="box" size=".05 .03 .1"/></body>
        <body><freejoint/><geom type="box" size=".02 .2 .04"/></body>
        </worldbody></mujoco>"""
    )
    data, corners = mujoco.MjData(model), np.array(list(product((-1.0, 1.0), repeat=3)))
    centres, rotations, distances, expected = [], [], [], []
    for _ in range(250):
        data.qpos[:] = rng.normal(size=14) * np.tile([0.2, 0.2, 0.2, 1.0, 1.0, 1.0, 1.0], 2)
        mujoco.mj_kinematics(model, data)
        c, R = data.geom_xpos.copy(), data.geom_xmat.reshape(2, 3, 3).copy()
        points = [c[i] + (corners * sizes[i]) @ R[i].T for i in (0, 1)]
        bounds = [gap(*points, axis) for axis in np.concatenate([R[0].T, R[1].T])]
        for i in (0, 1):  # from the box to the sphere around the other
            outside = np.abs(R[i].T @ (c[1 - i] - c[i])) - sizes[i]
            bounds.append(np.linalg.norm(outside.clip(0.0)) - np.linalg.norm(sizes[1 - i]))
        centres.append(c)
        rotations.append(R)
        expected.append(max(bounds))
        distances.append(mujoco.mj_geomDistance(model, data, 0, 1, 5.0, None))
    first, second = (
        Boxes(np.array(centres)[:, i], np.array(rotations)[:, i], np.tile(sizes[i], (250, 1)))
        for i in (0, 1)
    )
    bound, distance = box_distance(first, second, np.full(250, 5.0)), np.array(distances)
    assert bound == pytest.approx(np.array(expected))
    assert (bound <= distance + 1e-6).all() and np.mean((bound / distance)[distance > 0.05]) > 0.85
    rough = box_distance(first, second, np.full(250, 0.1))  # need not be tight beyond
    assert (rough <= bound + 1e-12).all() and ((rough >= 0.1) == (bound >= 0.1)).all()


def test_the_configurations_known_to_be_free_do_not_depend_on_paths_before():
    rng = np.random.default_rng(0)
    world, _ = arm_among_obstacles(rng)
    clearance = np.where(world.checked_pairs, 4e-3, -np.inf)
    ends = HOME + rng.normal(size=(24, 2, 7)) * np.array([[0.5], [2.0]])
    paths = [np.linspace(start, end, 60) for start, end in ends]

    def known(order):
        world.refresh()
        found = {i: world.known_free(paths[i], clearance).tolist() for i in order}
        return [found[i] for i in range(24)]

    assert known(range(24)) == known(reversed(range(24)))


def test_few_checks_are_needed_where_nothing_is_near(walled, monkeypatch):
    space = FreeSpace(walled.world, HOME)
    path = discretize_segment(HOME, HOME + [0.4, 0.1, -0.1, 0.2, 0.0, 0.1, 0.3], 2e-3)
    checks, collide = [], walled.world.collide
    monkeypatch.setattr(walled.world, "collide", lambda q: checks.append(1) or collide(q))
    assert space.path_is_free(path)
    assert len(checks) < len(path) / 10
