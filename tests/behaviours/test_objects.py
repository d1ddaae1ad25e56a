"""Behaviours that bring objects into the cell and take them out."""

import math

import mujoco
import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.behaviours import (
    IsHolding,
    IsIn,
    IsOn,
    ObjectExists,
    RemoveObject,
    SpawnObject,
    WaitUntilAtRest,
    extent,
    yaw_of,
)
from bt_manip.bt import NodeStatus
from bt_manip.cell import at_rest
from bt_manip.cell.objects import Box, Sphere
from bt_manip.exceptions import NodeError

RUNNING, SUCCESS, FAILURE = NodeStatus.RUNNING, NodeStatus.SUCCESS, NodeStatus.FAILURE


@pytest.fixture
def rising(station):
    """A cube that rises for ever."""
    station.cell.data.xfrc_applied[station.cell.body_id("cube")][:3] = [0.0, 0.0, 1.0]
    station.cell.step(50)
    return station


def test_spawned_objects_rest_in_the_region_with_unique_names_and_known_poses(station, trial):
    for name in ("cube_1", "cube_2"):
        region = "0.1;0.2;-0.3;-0.2"
        spawning = trial(SpawnObject(region=region, object="{object}", pose="{pose}"))
        assert spawning.tick() is SUCCESS
        assert spawning.tree.blackboard.get("object") == name
        spawned = station.cell.pose(name)
        assert spawning.tree.blackboard["pose"].isApprox(spawned, 1e-4)
        x, y, z = spawned.translation
        assert 0.1 <= x <= 0.2 and -0.3 <= y <= -0.2
        assert z == pytest.approx(1.015 + 0.025, abs=1e-3)
        station.cell.step(200)
        assert station.cell.pose(name).translation == pytest.approx([x, y, z], abs=1e-3)


def test_spawned_objects_never_stand_inside_each_other(station, trial):
    for _ in range(4):
        assert trial(SpawnObject(region="0.2;0.4;-0.3;-0.1", object="{o}")).tick() is SUCCESS
    assert station.cell.data.contact.dist.min() > -1e-3  # [m]
    assert np.ptp([yaw_of(station.cell.pose(f"cube_{i}")) for i in range(1, 5)]) > np.pi / 2
    crowded = trial(SpawnObject(region="0.3;0.3;0.1;0.1", object="{o}"))  # where the cube is
    assert crowded.fails_with("'cube_5' cannot be placed", "no free pose", "inside 'cube'")
    assert len(station.cell.objects) == 7  # table, basket, the cube, and four more


def test_where_objects_are_spawned_follows_the_stations_random_generator(station, trial):
    def spawn():
        station.rng.bit_generator.state = np.random.default_rng(7).bit_generator.state
        trial(SpawnObject(object="{object}")).tick()
        return station.cell.remove("cube_1") and station.rng.uniform()

    assert spawn() == spawn()


def test_a_cube_without_a_model_fits_the_gripper(station, trial, monkeypatch):
    for widest, size in ((0.056, 0.05), (0.0559, 0.04), (0.046, 0.032)):  # 6 mm more, then 0.8
        monkeypatch.setattr(type(station.gripper), "max_object_width", widest)
        assert trial(SpawnObject(region="0.1;0.1;-0.3;-0.3", object="{o}")).tick() is SUCCESS
        lower, upper = extent(station.cell, "cube_1")
        assert upper[2] - lower[2] == pytest.approx(size)
        station.cell.remove("cube_1")


@pytest.mark.parametrize(
    ("ports", "name"),
    [
        ({}, "cube"),
        ({"model": "can"}, "can"),
        ({"name_hint": "part"}, "part"),
        ({"model": "{m}"}, "*"),
    ],
)
def test_names_of_objects_that_are_spawned_are_known_before_as_patterns(trial, ports, name):
    assert trial(SpawnObject(object="{o}", **ports)).behaviour.adds_objects == [name, f"{name}_*"]


def test_an_unknown_model_is_found_before_anything_runs(trial):
    with pytest.raises(NodeError, match="unknown object 'cubs'; did you mean 'cube'"):
        trial(SpawnObject(model="cubs", object="{o}"))


def test_an_object_that_does_not_come_to_rest_in_time_fails_and_is_removed(rising, trial):
    waiting = trial(WaitUntilAtRest(object="cube", patience=0.2))
    assert waiting.fails_with("still after 0.2 s")
    assert "cube" in rising.cell.objects
    removing = trial(RemoveObject(object="cube", patience=0.2))
    assert removing.fails_with("'cube' moves at", "still after 0.2 s")
    assert "cube" not in rising.cell.objects


def test_an_object_that_vanishes_while_it_is_awaited_fails_the_behaviour(rising, trial):
    for behaviour in (RemoveObject(object="cube"), WaitUntilAtRest(object="cube")):
        waiting = trial(behaviour)
        state = rising.get_state()
        assert waiting.tick() is RUNNING
        rising.cell.remove("cube")
        assert waiting.fails_with("'cube'")
        rising.set_state(state)


def test_waiting_for_a_moving_object_ends_when_it_has_been_at_rest_for_50_ms(station, trial):
    cell = station.cell
    cell.data.qvel[-6:-3] = [0.3, 0.0, 0.0]  # the cube's linear velocity
    waiting = trial(WaitUntilAtRest(object="cube"))
    moved = cell.time
    while waiting.tick() is RUNNING:
        assert "'cube'" in waiting.behaviour.feedback_message
        if not at_rest(cell, "cube"):
            moved = cell.time
    assert waiting.behaviour.status.name == "SUCCESS"
    assert 0.05 <= cell.time - moved <= 0.08


def test_object_exists_looks_at_the_cell_at_every_tick(station, trial):
    looking = trial(ObjectExists(object="cube"))
    assert looking.tick() is SUCCESS
    assert trial(RemoveObject(object="cube")).tick() is SUCCESS  # it is at rest
    assert looking.tick() is FAILURE
    assert "no object 'cube'" in looking.behaviour.feedback_message


@pytest.mark.parametrize("within", [math.inf, 0.04])
def test_spawn_keeps_a_gap_from_what_lies_around_and_stays_near_it(station, trial, within):
    small = [0.22, 0.38, 0.02, 0.18]  # around the cube that is there
    for _ in range(3):
        spawn = SpawnObject(region=small, gap=0.01, within=within, object="{new}")
        assert trial(spawn).tick() is SUCCESS
        model, data = station.cell.model, station.cell.data
        names = ("cube/", "cube_1/")
        a, b = ([g for g in range(model.ngeom) if model.geom(g).name.startswith(n)] for n in names)
        least = min(mujoco.mj_geomDistance(model, data, x, y, 1.0, None) for x in a for y in b)
        assert 0.01 <= least < within
        station.cell.remove("cube_1")


def test_what_cannot_be_spawned_fails_with_the_reason(station, trial):
    for ports, message in (
        ({"model": "{later}"}, "unknown object 'cubs'; did you mean 'cube'"),
        ({"on": "cube"}, "no surface"),
        ({"region": "0.4;0.2;0;0.1"}, "x_min;x_max"),
        (
            {"region": [0.3, 0.4, -0.25, -0.2], "within": 0.05},
            "other objects and at most 50 mm from one in 100 attempts",
        ),
    ):
        spawning = trial(SpawnObject(object="{new}", **ports))
        spawning.tree.blackboard["later"] = "cubs"
        assert spawning.fails_with(message)
        assert "cube_1" not in station.cell.objects


def test_where_an_object_rests_is_checked_from_the_physics(station, trial):
    assert trial(IsOn(object="cube", support="table")).tick() is SUCCESS
    assert trial(IsIn(object="cube", container="basket")).fails_with("'cube' touches 'table'")
    assert trial(IsOn(object="cube", support="basket")).fails_with("does not touch 'basket'")
    assert trial(IsIn(object="ball", container="basket")).fails_with("'ball'")


def test_a_held_object_rests_nowhere(with_the_cube, trial):
    for condition in (
        IsOn(object="cube", support="table"),
        IsIn(object="cube", container="basket"),
    ):
        assert trial(condition).fails_with("'cube' touches 'panda/")


@pytest.mark.parametrize(("plate", "z"), [
    (Box(size=(0.2, 0.2, 0.02)), 0.01),  # 1 mm over the fingertips
    (Sphere(radius=0.1), 0.098),  # they press on it 24 degrees from its top
])  # fmt: skip
def test_what_both_fingers_press_on_from_above_is_not_held(station, trial, plate, z):
    T_to = spatial.pose((0.0, 0.0, z))
    station.cell.add(plate, station.robot.tool_pose * T_to, name="plate", free=False, overlap=0.01)
    station.cell.step(20)
    assert station.gripper.held == ("plate",)
    assert trial(IsHolding(object="plate")).fails_with("press on one side of 'plate'")
