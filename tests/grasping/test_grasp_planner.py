"""Failures of grasp planning."""

import contextlib
import json

import mujoco
import numpy as np
import pytest
from dm_control import composer, mjcf

from bt_manip.collision import CollisionPair
from bt_manip.exceptions import MotionError
from bt_manip.grasping import GraspPlanner, GripperClearance
from bt_manip.grasping.gripper_clearance import Clearance
from bt_manip.planning import LineTo, follow_tool_path, tool_paths
from bt_manip.spatial import pose


def test_an_arm_that_would_collide_with_itself_does_not_wait_for_itself(station, monkeypatch):
    own = CollisionPair("panda/link7", "panda/link2", -0.01)
    monkeypatch.setattr(station.arm.world, "collisions", lambda q, within=0.0: [own])
    planner = GraspPlanner(station.cell, station.arm)
    with pytest.raises(MotionError, match="'panda/link7' would touch 'panda/link2'") as raised:
        planner.plan("cube", [0.1], station.cell.pose("cube").translation)
    assert raised.value.reason == "grasp"


def test_a_plan_holds_until_the_object_or_the_arm_has_moved_or_something_is_in_the_way(
    station, monkeypatch
):
    cell, arm, name = station.cell, station.arm, "cube"
    planner = GraspPlanner(cell, arm)
    plan = planner.plan(name, [0.1], cell.pose(name).translation)
    assert planner.checked.object == name
    assert planner.checked.closing == pytest.approx([0.0, 1.0, 0.0])
    assert planner.planned(name) is None
    arm.reset(plan.q_pregrasp)
    assert planner.planned(name) is plan
    state = planner.get_state()
    planner.set_state(json.loads(json.dumps(state)))
    restored = planner.planned(name)
    for gap, fits in ((-0.0029, True), (-0.0031, False)):  # 3 mm of penetration are accepted
        monkeypatch.setattr(GripperClearance, "at_pose", lambda *_, gap=gap: Clearance(gap, "post"))
        assert (planner.planned(name) is restored) == fits
        with (
            contextlib.nullcontext() if fits else pytest.raises(MotionError, match="'post' leaves")
        ):
            planner.check_clearance(name, plan.T_wt)
    monkeypatch.undo()
    (line,) = tool_paths(arm.model.pose(arm.q), [LineTo(restored.T_wt)])
    assert np.array_equal(follow_tool_path(arm.ik, arm.q, line).knots, plan.approach.knots)
    for moved, holds in ((8e-6, True), (4e-6, False)):  # by 8 and by 12 micrometres in all
        cell.move(name, pose((moved, 0.0, 0.0)) * cell.pose(name))
        assert (planner.planned(name) is restored) == holds


def test_the_candidates_of_an_object_with_a_joint_follow_the_joint(station):
    class Slider(composer.Entity):
        """A block on a fixed foot, on which it slides."""

        def _build(self):
            self._root = mjcf.RootElement(model="slider")
            self._root.worldbody.add("geom", type="box", size=[0.04, 0.04, 0.02], mass=0.1)
            block = self._root.worldbody.add("body", name="block", pos=[0.0, 0.0, 0.05])
            block.add("joint", type="slide", axis=[1, 0, 0], name="slide")
            block.add("geom", type="box", size=[0.02, 0.02, 0.03], mass=0.1)

        mjcf_model = property(lambda self: self._root)

    def plan(planner):
        return planner.plan(name, [0.1], cell.pose(name).translation).grasp.T_ot.homogeneous

    cell = station.cell
    cell.remove("cube")
    name = cell.add(Slider(), pose((0.4, 0.0, 1.036)), free=False)
    planner = GraspPlanner(cell, station.arm)
    before = plan(planner)
    cell.data.qpos[cell.model.joint("slider/slide").qposadr[0]] = 0.03
    mujoco.mj_forward(cell.model, cell.data)
    after = plan(planner)
    assert (after == plan(GraspPlanner(cell, station.arm))).all()
    assert after[0, 3] - before[0, 3] == pytest.approx(0.03, abs=1e-3)
