"""Failures of grasp planning."""

import pytest

from bt_manip.collision import CollisionPair
from bt_manip.exceptions import MotionError
from bt_manip.grasping import GraspPlanner
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
