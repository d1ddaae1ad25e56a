"""What the arm would touch, held against the physics itself."""

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.cell import Cell, objects
from bt_manip.collision import CollisionWorld, FreeSpace
from bt_manip.collision.scratch_model import moved_bodies
from bt_manip.robots import Robot, panda
from tests.robot_fixtures import Box

HOME = np.array(panda().home)


def in_hand(open_by: float = 0.025) -> tuple[Cell, Robot]:
    """A cube between the fingers, in the air, and a plate under the cube."""
    cell, robot = Cell(), Robot(panda())
    cell.add(robot, spatial.pose((0.0, 0.0, 1.0)), free=False)
    robot.set_configuration(HOME)
    robot.mj_data.qpos[robot.gripper_qpos_adr] = open_by - 1e-4
    mujoco.mj_forward(cell.model, cell.data)
    T_to = spatial.pose((0.0, 0.0, 0.015))  # clear of the palm
    cell.add(objects.Cube(), robot.tool_pose * T_to, name="cube")
    return cell, robot


def test_its_verdict_is_that_of_the_physics(walled, rng):
    model, data = walled.cell.model, mujoco.MjData(walled.cell.model)
    data.qpos[:] = walled.cell.data.qpos
    limits, world = walled.robot.limits, walled.world
    of_arm = moved_bodies(model, walled.robot.dof_adr)[model.geom_bodyid]
    touching = 0
    for q in rng.uniform(limits.lower, limits.upper, (400, 7)):
        data.qpos[walled.robot.qpos_adr] = q
        mujoco.mj_forward(model, data)
        geoms = data.contact.geom[data.contact.efc_address >= 0]
        expected = bool(of_arm[geoms].any())
        assert bool(world.collisions(q)) == expected
        touching += expected
    assert 50 < touching < 350


def test_it_names_the_bodies_and_how_deep_they_are_in_each_other(walled):
    q = walled.ik.solve(spatial.pointing_down((0.5, 0.0, 0.3), 0.0), HOME).q
    pairs = {(near.first, near.second) for near in walled.world.collisions(q)}
    assert ("panda/hand", "wall") in pairs
    nearest = walled.world.collisions(q)[0]
    assert nearest.distance < -0.02


def test_nearness_is_the_distance_in_the_world(walled):
    gap = 5e-3  # [m] between the finger tips, 9.5 mm below the tool, and the table
    q = walled.ik.solve(spatial.pointing_down((0.5, 0.3, 0.0095 + gap), 0.0), HOME).q
    assert not walled.world.collisions(q)
    (first, second) = walled.world.collisions(q, 8e-3)
    assert {first.first, second.first} == {"panda/left_finger", "panda/right_finger"}
    assert first.distance == pytest.approx(gap, abs=2e-4)


def test_looking_leaves_the_physics_as_it_is(walled):
    before = walled.cell.state_bytes()
    walled.world.collisions(HOME + 0.1)
    assert walled.cell.state_bytes() == before


def test_what_the_fingers_hold_goes_with_the_tool():
    cell, robot = in_hand()
    world = CollisionWorld(robot, robot.make_model())
    assert world.held == "cube"
    assert not world.collisions(HOME)
    # 30 mm under the tool there is nothing of the hand, but the cube is in the way there.
    tool = robot.tool_pose.translation
    cell.add(Box((0.3, 0.3, 0.02)), spatial.pose(tool - [0.0, 0.0, 0.05]), name="plate")
    world.refresh()
    assert not world.collisions(HOME)
    lower = HOME.copy()
    lower[1] += 0.07  # leans forward: the tool sinks by about 35 mm
    assert ("cube", "plate") in {(near.first, near.second) for near in world.collisions(lower)}


def test_what_lies_between_open_fingers_is_not_held_and_is_in_the_way():
    cell, robot = in_hand(open_by=0.04)
    world = CollisionWorld(robot, robot.make_model())
    assert world.held is None
    sideways = HOME.copy()
    sideways[0] += 0.05
    assert "cube" in {near.second for near in world.collisions(sideways)}


AWAY = HOME + np.array([0.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_things_that_come_and_go_are_seen_after_a_refresh():
    cell, robot = Cell(), Robot(panda())
    cell.add(robot, spatial.pose((0.0, 0.0, 1.0)), free=False)
    world = CollisionWorld(robot, robot.make_model())
    cell.add(Box((0.1, 0.1, 0.1)), robot.make_model().pose(AWAY), name="box")
    assert not world.collisions(AWAY)
    world.refresh()
    assert {near.second for near in world.collisions(AWAY)} == {"box"}
    cell.remove("box")
    world.refresh()
    assert not world.collisions(AWAY)


def test_geoms_that_collide_with_some_only_keep_doing_so():
    cell, robot = Cell(), Robot(panda())
    cell.add(robot, spatial.pose((0.0, 0.0, 1.0)), free=False)
    ghost, wall = Box((0.1, 0.1, 0.1)), Box((0.1, 0.1, 0.1))
    geom = ghost.mjcf_model.worldbody.geom[0]
    geom.contype, geom.conaffinity = 2, 2
    geom = wall.mjcf_model.worldbody.geom[0]
    geom.contype, geom.conaffinity = 0, 1
    tool = robot.make_model().pose(AWAY)
    cell.add(ghost, tool, name="ghost")
    cell.add(wall, tool, name="wall")
    world = CollisionWorld(robot, robot.make_model())
    assert {near.second for near in world.collisions(AWAY)} == {"wall"}


def test_free_space_keeps_a_clearance_but_not_from_what_is_nearer_at_the_end(walled):
    def at(gap):
        T = spatial.pointing_down((0.5, 0.3, 0.0095 + gap), 0.0)
        return walled.ik.solve(T, HOME).q

    space = FreeSpace(walled.world, HOME, clearance=5e-3)
    assert space.is_free(at(6e-3)) and not space.is_free(at(3e-3))
    space = FreeSpace(walled.world, HOME, [at(2e-3)], clearance=5e-3)
    assert space.is_free(at(3e-3)) and not space.is_free(at(1e-3))


def test_what_touches_at_the_start_may_be_left_but_not_entered(walled):
    def at(height):
        T = spatial.pointing_down((0.5, 0.3, 0.0095 + height), 0.0)
        return walled.ik.solve(T, walled.ik.solve(walled.left, HOME).q).q

    space = FreeSpace(walled.world, at(-3e-3))
    assert space.is_free(at(-2e-3)) and space.is_free(at(20e-3))
    assert not space.is_free(at(-6e-3))
    beside = walled.ik.solve(spatial.pointing_down((0.5, 0.4, 0.0075), 0.0), at(-3e-3)).q
    assert np.abs(beside - at(-3e-3)).max() > 0.05
    assert not space.is_free(beside)  # still inside, too far from the start
