"""Faults of objects do what they say in the physics, and are undone."""

from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from bt_manip.behaviours import MoveToConfiguration, RemoveObject
from bt_manip.cell import at_rest, extent
from bt_manip.scenes import SceneObject
from bt_manip_stress import FaultContext, FaultError
from bt_manip_stress.faults.object_faults import (
    ContainerVanishes,
    Displace,
    Heavy,
    Knock,
    Obstacle,
    Slippery,
    Stuck,
    Vanish,
)
from bt_manip_stress.faults.places import Places

TARGET = [1.2, 0.3, 0.0, -1.8, 0.0, 2.1, 0.8]  # [rad]
BASE, TABLE = np.array([-0.1, 0.0]), 1.015


def distance_from_base(station):
    return np.linalg.norm(station.cell.pose("cube").translation[:2] - BASE)


def lies_on_the_table_within_reach(station):
    height = station.cell.pose("cube").translation[2]
    return 0.3 < distance_from_base(station) < 0.62 and abs(height - TABLE - 0.025) < 0.02


def test_an_object_of_the_scene_that_vanishes_comes_back_for_the_next_cycle(station, start):
    cell, pose = station.cell, station.cell.pose("cube")
    cube = SceneObject("cube", "cube", pose)
    scene = replace(station.scene, objects=(*station.scene.objects, cube))
    fault = start(Vanish(), within=replace(station, scene=scene))
    assert "cube" not in cell.entities
    fault.end()
    assert cell.pose("cube").isApprox(pose) and cell.is_free("cube")


def test_a_fault_of_an_object_that_is_not_there_does_not_happen(station, start):
    station.cell.remove("cube")
    with pytest.raises(FaultError, match="there is no object"):
        start(Vanish())
    with pytest.raises(FaultError, match="there is no object 'cup'"):
        start(Vanish(object="cup"))
    with pytest.raises(FaultError, match="'table' does not move freely"):
        start(Heavy(object="table"))


@pytest.mark.parametrize("seed", range(2))
def test_an_object_moves_to_another_place_within_reach(station, start, seed):
    before = station.cell.pose("cube").translation
    start(Displace(), seed)
    station.cell.step(200)
    assert np.linalg.norm(station.cell.pose("cube").translation - before) > 0.1
    assert lies_on_the_table_within_reach(station) and at_rest(station.cell, "cube")


@pytest.mark.parametrize(
    ("situation", "seed"),
    [
        ("at rest", 0),
        ("around the cube", 1),
        ("around the cube", 2),
        ("holding a cube over the table", 0),
    ],
)
def test_an_object_that_is_knocked_away_stays_on_the_table_within_reach(
    situations, start, situation, seed
):
    station = situations.reset(situation)
    before = station.cell.pose("cube").translation
    context = FaultContext(station, None, None, np.random.default_rng(seed))
    first = next(iter(Places(context, "cube", 0.1).sample())).translation
    start(Knock(), seed)
    station.cell.step(1000)
    if seed == 0:  # with others, it is thrown elsewhere
        assert np.linalg.norm((station.cell.pose("cube").translation - first)[:2]) < 0.04
    assert not station.gripper.held
    assert np.linalg.norm((station.cell.pose("cube").translation - before)[:2]) > 0.1
    assert lies_on_the_table_within_reach(station)


def test_a_physical_property_changes_until_the_fault_ends_and_one_of_the_run_is_restored(
    station, start
):
    cell = station.cell
    slippery = start(Slippery(friction=0.01))
    assert cell.overrides["cube"] == {"friction": 0.01}
    slippery.end()
    assert not cell.overrides
    cell.override("cube", mass=0.5)
    heavy = start(Heavy(mass=3.0))
    assert cell.overrides["cube"] == {"mass": 3.0}
    heavy.end()
    assert cell.overrides["cube"] == {"mass": 0.5}
    heavy = start(Heavy())
    assert cell.overrides["cube"] == {"mass": 10.0}
    cell.remove("cube")
    heavy.end()


def test_a_stuck_object_does_not_move_when_it_is_pulled(station, start):
    cell = station.cell
    before = cell.pose("cube").translation
    fault = start(Stuck())
    cell.data.xfrc_applied[cell.body_id("cube"), :3] = (0.0, 0.0, 50.0)
    cell.step(1000)
    assert np.linalg.norm(cell.pose("cube").translation - before) < 2e-3
    fault.end()
    cell.step(50)
    assert cell.pose("cube").translation[2] > before[2] + 0.1


@pytest.mark.start("holding a cube over the table")
def test_an_obstacle_appears_ahead_of_the_tool_and_disappears(station, start, trial):
    cell = station.cell
    motion = trial(MoveToConfiguration(configuration=TARGET))
    motion.tick()
    fault = start(Obstacle(clearance=0.05))
    tool = station.robot.tool_pose.translation
    assert np.linalg.norm(cell.pose("obstacle").translation[:2] - tool[:2]) > 0.1
    fault.end()
    assert "obstacle" not in cell.entities


def test_without_a_motion_an_obstacle_is_above_the_middle_of_object_and_container(station, start):
    cell = station.cell
    cube, basket = (cell.pose(name).translation for name in ("cube", "basket"))
    start(Obstacle(width=0.02, height=0.22, clearance=0.01))
    place = cell.pose("obstacle").translation
    assert place == pytest.approx((cube + basket) / 2 + [0.0, 0.0, 0.35 - 0.11])
    assert np.ptp(extent(cell, "obstacle"), axis=0) == pytest.approx([0.02, 0.02, 0.22])


def test_an_obstacle_leaves_the_end_of_the_motion_free(station, start, trial):
    motion = trial(MoveToConfiguration(configuration=TARGET))
    motion.tick()
    start(Obstacle(clearance=0.0, distance=0.6))
    world = station.arm.world
    world.refresh()
    assert not world.collisions(station.arm.target)


def test_a_container_vanishes_and_comes_back(station, start):
    cell = station.cell
    pose = cell.pose("basket")
    fault = start(ContainerVanishes())
    assert "basket" not in cell.entities
    fault.end()
    assert cell.pose("basket").isApprox(pose) and "basket" in cell.objects


def test_the_object_of_a_node_is_that_of_its_port(station, start, trial):
    cell = station.cell
    cell.add(station.models.create("cube"), cell.pose("cube"), name="other", overlap=1.0)
    tree = trial(RemoveObject(object="cube")).tree
    start(Vanish(), tree=tree)
    assert "cube" not in cell.entities and "other" in cell.entities


def test_places_for_an_object_are_at_least_a_distance_and_at_most_the_farthest_away(station):
    context = FaultContext(station, None, None, np.random.default_rng(0))
    here = station.cell.pose("cube").translation[:2]
    for distance in (0.05, 0.2):
        places = islice(Places(context, "cube", distance).sample(), 30)
        away = [np.linalg.norm(T.translation[:2] - here) for T in places]
        assert distance <= min(away) and 0.35 < max(away) <= 0.4
    assert min(away) < 0.3  # also near ones
    model, rng = station.arm.model, np.random.default_rng(1)
    bounds, base = model.limits.sampling_bounds(), station.cell.pose("panda").translation
    tools = [model.pose(rng.uniform(*bounds)).translation - base for _ in range(500)]
    places = [T.translation for T in islice(Places(context, "cube", 0.0).sample(), 300)]
    assert 0.34 < np.abs(places)[:, 1].max() <= 0.37  # 3 cm from the edge of the table, at 0.4 m
    shares = np.linalg.norm(places - base, axis=1) / np.linalg.norm(tools, axis=1).max()
    assert (min(shares), max(shares)) == pytest.approx((0.25, 0.46), abs=0.03)


def test_the_same_seed_moves_an_object_to_the_same_place(situations, start):
    places = []
    for seed in (1, 1, 2):
        station = situations.reset()
        start(Displace(), seed)
        places.append(station.cell.pose("cube").translation.tolist())
    assert places[0] == places[1] != places[2]
