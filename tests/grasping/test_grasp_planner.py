"""Failures of grasp planning."""

import json

import numpy as np
import pytest

from bt_manip.collision import CollisionPair
from bt_manip.exceptions import MotionError
from bt_manip.grasping import GraspPlanner
from bt_manip.planning import LineTo, follow_tool_path, tool_paths
from bt_manip.runner import build_station
from bt_manip.spatial import pose


def test_an_arm_that_would_collide_with_itself_does_not_wait_for_itself(monkeypatch):
    station = build_station()
    height = station.cell.pose("table").translation[2] + station.cell.surface_height("table")
    name = station.cell.add(station.models.create("cube"), pose((0.3, 0.0, height + 0.026)))
    own = CollisionPair("panda/link7", "panda/link2", -0.01)
    monkeypatch.setattr(station.arm.world, "collisions", lambda q, within=0.0: [own])
    planner = GraspPlanner(station.cell, station.arm)
    with pytest.raises(MotionError, match="'panda/link7' would touch 'panda/link2'") as raised:
        planner.plan(name, [0.1], station.cell.pose(name).translation)
    assert raised.value.reason == "grasp"


def test_a_plan_holds_until_the_object_or_the_arm_has_moved():
    station = build_station()
    cell, arm = station.cell, station.arm
    height = cell.pose("table").translation[2] + cell.surface_height("table")
    name = cell.add(station.models.create("cube"), pose((0.3, 0.0, height + 0.026)))
    planner = GraspPlanner(cell, arm)
    plan = planner.plan(name, [0.1], cell.pose(name).translation)
    assert planner.planned(name) is None
    arm.reset(plan.q_pregrasp)
    assert planner.planned(name) is plan
    state = planner.get_state()
    planner.set_state(json.loads(json.dumps(state)))
    restored = planner.planned(name)
    (line,) = tool_paths(arm.model.pose(arm.q), [LineTo(restored.T_wt)])
    assert np.array_equal(follow_tool_path(arm.ik, arm.q, line).knots, plan.approach.knots)
    cell.move(name, pose((0.301, 0.0, height + 0.026)))
    assert planner.planned(name) is None
