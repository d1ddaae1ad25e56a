"""Clearance of the open gripper at tool poses."""

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.behaviours import centre_pose, top_grasp_poses
from bt_manip.cell import Cube
from bt_manip.cell.objects import Box
from bt_manip.grasping import GripperClearance, with_clearance


@pytest.fixture
def grips(station):
    return top_grasp_poses(centre_pose(station.cell, "cube"), 0.015)


def test_the_clearance_is_the_distance_to_the_nearest_entity(station, grips):
    alone = GripperClearance(station.cell, station.robot, ["cube"]).at_pose(grips[0])
    # The fingertips end 9.5 mm below the tool centre point, which is 40 mm above the table.
    assert alone.entity == "table" and alone.distance == pytest.approx(0.0305, abs=1e-3)
    # Open pads end 55 mm from the centre: a cube at 90 mm begins at 65 mm.
    axis = grips[0].rotation[:, 1]
    cube = station.cell.pose("cube")
    station.cell.add(Cube(), pin.SE3(cube.rotation, cube.translation + 0.09 * axis), name="other")
    beside = GripperClearance(station.cell, station.robot, ["cube"]).at_pose(grips[0])
    assert beside.entity == "other" and 0.0 < beside.distance < 0.0105
    # A beam as thick as the cube that begins at 60 mm, and whose centre is 2 m farther.
    R = np.column_stack([axis, np.cross([0.0, 0.0, 1.0], axis), [0.0, 0.0, 1.0]])
    beam, T_wb = Box(size=(4.0, 0.05, 0.05)), pin.SE3(R, cube.translation + 2.06 * axis)
    station.cell.add(beam, T_wb, name="beam", free=False, overlap=1.0)
    along = GripperClearance(station.cell, station.robot, ["cube", "other"]).at_pose(grips[0])
    assert along.entity == "beam" and along.distance == pytest.approx(5e-3, abs=2e-3)


def test_what_is_ignored_can_be_changed(station, grips):
    clearance = GripperClearance(station.cell, station.robot, [])
    assert clearance.at_pose(grips[0]).entity == "cube"
    clearance.ignore(["cube"])
    alone = GripperClearance(station.cell, station.robot, ["cube"])
    assert clearance.at_pose(grips[0]) == alone.at_pose(grips[0])
    clearance.ignore([])
    assert clearance.at_pose(grips[0]).entity == "cube"


def test_geoms_count_if_they_collide_in_either_role(station, grips):
    model = station.cell.model
    hand = next(iter(GripperClearance(station.cell, station.robot, []).geom_poses))
    cube = model.body_rootid[model.geom_bodyid] == station.cell.body_id("cube")
    own = model.geom_contype.copy(), model.geom_conaffinity.copy()
    try:
        for bits in ((0, 1), (1, 0), (0, 0)):
            for geom in (hand, cube):
                model.geom_contype[geom], model.geom_conaffinity[geom] = bits
            clearance = GripperClearance(station.cell, station.robot, [])
            assert (hand in clearance.geom_poses) == any(bits)
            assert (clearance.at_pose(grips[0]).entity == "cube") == any(bits)
    finally:
        model.geom_contype[:], model.geom_conaffinity[:] = own


def test_poses_with_sufficient_clearance_are_selected(station, grips):
    cube = station.cell.pose("cube")
    beside = cube.translation + 0.07 * grips[0].rotation[:, 1]
    station.cell.add(Cube(), pin.SE3(cube.rotation, beside), name="other")
    clearance = GripperClearance(station.cell, station.robot, ["cube"])
    free, largest = with_clearance(grips, clearance)
    assert [T for T in grips if clearance.at_pose(T).distance >= 4e-3] == free
    assert len(free) == 2 and largest.distance >= 4e-3


def test_an_object_lifted_into_an_obstacle_has_negative_clearance(station):
    cube = station.cell.pose("cube")
    above = cube.translation + [0.0, 0.0, 0.08]
    station.cell.add(Cube(), pin.SE3(cube.rotation, above), name="other")
    clearance = GripperClearance(station.cell, station.robot, ["cube"])
    lifted = clearance.of_displaced("cube", [[0.0, 0.0, 0.05]])
    assert lifted.entity == "other" and lifted.distance == pytest.approx(-0.02, abs=1e-3)
    assert clearance.of_displaced("cube", [[0.0, 0.0, 0.02]]).distance == pytest.approx(0.01)
    assert clearance.of_displaced("cube", [[0.0, 0.0, 1.0]]) == (0.02, "")
    assert clearance.at_pose(pin.SE3(cube.rotation, above + [0.0, 0.0, 5.0])) == (0.1, "")


def test_the_gripper_has_the_same_bits_wherever_the_arm_is(station):
    def bits():
        poses = GripperClearance(station.cell, station.robot, []).geom_poses
        return {geom: T.homogeneous.tobytes() for geom, T in poses.items()}

    before, state = bits(), station.get_state()
    station.robot.set_configuration(station.robot.q + 0.1)
    station.robot.gripper.set_opening(station.cell.data.qpos, 0.3)
    after = bits()
    station.set_state(state)
    assert before == after
