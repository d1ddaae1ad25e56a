"""Collision checking of an arm, compared with the contacts of the simulation."""

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.cell import Cell, objects
from bt_manip.collision import PADDING, CollisionWorld
from bt_manip.collision.robot_geometry import moved_bodies
from bt_manip.exceptions import MotionError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from tests.robot_fixtures import Box

HOME = np.array(panda().home)


def in_the_air() -> tuple[Cell, Robot]:
    """Return a robot in the air, at home."""
    cell, robot = Cell(), Robot(panda(), gripper=TwoFingerGripper)
    cell.add(robot, spatial.pose((0.0, 0.0, 1.0)), free=False)
    return cell, robot


def with_cube(open_by: float = 0.025) -> tuple[Cell, Robot]:
    """Return a robot in the air with a cube between its fingers."""
    cell, robot = in_the_air()
    robot.set_configuration(HOME)
    robot.mj_data.qpos[robot.gripper.mechanism.qpos_adr] = open_by - 1e-4
    mujoco.mj_forward(cell.model, cell.data)
    T_to = spatial.pose((0.0, 0.0, 0.015))  # clear of the palm
    cell.add(objects.Cube(), robot.tool_pose * T_to, name="cube")
    return cell, robot


def test_it_finds_a_collision_where_the_simulation_finds_a_contact(walled, rng):
    before = walled.cell.state_bytes()
    model, data = walled.cell.model, mujoco.MjData(walled.cell.model)
    data.qpos[:] = walled.cell.data.qpos
    limits, world = walled.robot.limits, walled.world
    of_arm = moved_bodies(model, walled.robot.dof_adr)[model.geom_bodyid]
    touching = 0
    for q in rng.uniform(limits.lower, limits.upper, (200, 7)):
        data.qpos[walled.robot.qpos_adr] = q
        mujoco.mj_forward(model, data)
        geoms = data.contact.geom[data.contact.efc_address >= 0]
        expected = bool(of_arm[geoms].any())
        assert bool(world.collisions(q)) == expected
        touching += expected
    assert 25 < touching < 175
    assert walled.cell.state_bytes() == before


def test_collisions_and_bodies_within_a_distance_are_named_with_their_distance(walled):
    q = walled.ik.solve(spatial.pointing_down((0.5, 0.0, 0.3), 0.0), HOME).q
    found = walled.world.collisions(q)
    assert ("panda/hand", "wall") in {(pair.first, pair.second) for pair in found}
    assert found[0].distance < -0.02
    gap = 5e-3  # [m] between the finger tips, 9.5 mm below the tool, and the table
    q = walled.ik.solve(spatial.pointing_down((0.5, 0.3, 0.0095 + gap), 0.0), HOME).q
    assert not walled.world.collisions(q)
    (first, second) = walled.world.collisions(q, 8e-3)
    assert {first.first, second.first} == {"panda/left_finger", "panda/right_finger"}
    assert first.distance == pytest.approx(gap, abs=2e-4)
    assert not walled.world.collisions(HOME, PADDING)
    with pytest.raises(MotionError, match=r"within must be at most 0\.008 \[m\], got 0\.02"):
        walled.world.collisions(HOME, 0.02)


def test_the_held_object_moves_with_the_tool():
    cell, robot = with_cube()
    world = CollisionWorld(robot, robot.make_model())
    assert world.held == "cube"
    assert not world.collisions(HOME)
    # 30 mm under the tool there is nothing of the hand, but there is the cube.
    tool = robot.tool_pose.translation
    cell.add(Box((0.3, 0.3, 0.02)), spatial.pose(tool - [0.0, 0.0, 0.05]), name="plate")
    world.refresh()
    assert not world.collisions(HOME)
    lower = HOME.copy()
    lower[1] += 0.07  # leans forward: the tool sinks by about 35 mm
    assert ("cube", "plate") in {(pair.first, pair.second) for pair in world.collisions(lower)}


def test_an_object_between_open_fingers_is_not_held_and_is_an_obstacle():
    cell, robot = with_cube(open_by=0.04)
    world = CollisionWorld(robot, robot.make_model())
    assert world.held is None
    sideways = HOME.copy()
    sideways[0] += 0.05
    assert "cube" in {pair.second for pair in world.collisions(sideways)}


AWAY = HOME + np.array([0.6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_objects_added_and_removed_are_known_after_a_refresh():
    cell, robot = in_the_air()
    world = CollisionWorld(robot, robot.make_model())
    cell.add(Box((0.1, 0.1, 0.1)), robot.make_model().pose(AWAY), name="box")
    assert not world.collisions(AWAY)
    world.refresh()
    assert {pair.second for pair in world.collisions(AWAY)} == {"box"}
    cell.remove("box")
    world.refresh()
    assert not world.collisions(AWAY)


def test_a_state_of_fixed_things_only_has_no_free_object_and_an_open_empty_gripper():
    cell, robot = with_cube()
    model = robot.make_model()
    below = model.pose(AWAY) * spatial.pose((0.0, 0.0, 0.04))  # of the cube, not of the hand
    across = model.pose(AWAY) * spatial.pose((0.0, 0.053, -0.01))  # beside the closed finger
    with cell.editing():
        cell.add(objects.Cube(), model.pose(HOME - (AWAY - HOME)), name="free")
        cell.add(Box((0.02, 0.02, 0.02)), below, name="below")
        cell.add(Box((0.02, 0.01, 0.02)), across, name="across")
    world = CollisionWorld(robot, model)
    ahead = HOME - (AWAY - HOME)
    found = [{pair.second for pair in world.collisions(q)} for q in (AWAY, ahead)]
    assert world.held == "cube" and found[0] == {"below"} and "free" in found[1]
    before = cell.state_bytes()
    world.refresh(fixed_only=True)
    found = [{pair.second for pair in world.collisions(q)} for q in (AWAY, ahead)]
    assert world.held is None and found == [{"across"}, set()]
    assert cell.state_bytes() == before


def test_contact_types_of_the_model_are_respected():
    cell, robot = in_the_air()
    ghost, wall = Box((0.1, 0.1, 0.1)), Box((0.1, 0.1, 0.1))
    geom = ghost.mjcf_model.worldbody.geom[0]
    geom.contype, geom.conaffinity = 2, 2
    geom = wall.mjcf_model.worldbody.geom[0]
    geom.contype, geom.conaffinity = 0, 1
    tool = robot.make_model().pose(AWAY)
    cell.add(ghost, tool, name="ghost")
    cell.add(wall, tool, name="wall")
    world = CollisionWorld(robot, robot.make_model())
    assert {pair.second for pair in world.collisions(AWAY)} == {"wall"}


def test_geoms_that_move_as_one_are_not_checked():
    cell, robot = in_the_air()
    world = CollisionWorld(robot, robot.make_model())
    of_geom = cell.model.geom_bodyid
    hand, finger = (of_geom == cell.body_id(f"panda/{name}") for name in ("hand", "left_finger"))
    link5 = of_geom == cell.body_id("panda/link5")
    assert not world.checked_pairs[hand][:, finger].any()
    assert world.checked_pairs[link5][:, finger].any()
