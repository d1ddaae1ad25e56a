"""The friction of a grip is the object's, in the physics and in grasp planning."""

import numpy as np
import pytest

from bt_manip import build_station
from bt_manip.cell import Cell, Cube
from bt_manip.cell.objects import ConvexMesh
from bt_manip.exceptions import MotionError
from bt_manip.grasping import GraspPlanner, check_friction
from bt_manip.grippers import contact_friction, solids_of
from bt_manip.robots import GripperError
from bt_manip.spatial import pose
from tests.grippers.conftest import built_grip as built_grip
from tests.grippers.conftest import grip as grip

ON_THE_TABLE = pose((0.3, 0.0, 1.015 + 0.0255))
THRESHOLD = 0.0565 * 9.81 / 100.0  # the cube's weight over 2 x 50 N


def grip_it(cell, gripper):
    gripper.close(50.0)
    while not gripper.steady:
        cell.step()
        assert cell.time < 1.0, "no steady grip"
    cell.remove("post")


def fall_of(cell) -> float:
    """Return how far the cube falls in 0.3 s [m]."""
    before = cell.pose("cube").translation[2]
    cell.step(300)
    return float(before - cell.pose("cube").translation[2])


def contact_frictions(cell: Cell, gripper) -> set[float]:
    """Return the sliding friction of all contacts of fingers and cube."""
    contact, fingers = cell.data.contact, gripper.contact_body_ids
    bodies = cell.model.geom_bodyid[contact.geom]
    cube = cell.model.body_rootid[bodies] == cell.body_id("cube")
    both = cube.any(axis=1) & np.isin(bodies, fingers).any(axis=1)
    assert both.sum() >= 2
    return set(contact.friction[both, 0].tolist())


@pytest.mark.parametrize("friction", [0.05, 2.0])
def test_contacts_have_the_friction_that_grasp_planning_uses(grip, friction):
    cell, _, _, gripper = grip
    cell.override("cube", friction=friction)
    cell.override("panda", friction=1e-3)  # that of the robot does not count
    grip_it(cell, gripper)
    assert contact_frictions(cell, gripper) == {contact_friction(solids_of(cell, "cube"))}
    assert contact_frictions(cell, gripper) == {friction}
    assert fall_of(cell) < 1e-4


@pytest.mark.parametrize(("times", "falls"), [(0.8, True), (1.2, False)])
def test_a_cube_hangs_from_weight_over_twice_the_force_on(grip, times, falls):
    cell, _, _, gripper = grip
    grip_it(cell, gripper)
    cell.override("cube", friction=times * THRESHOLD)
    assert (fall_of(cell) > 0.05) is falls


@pytest.fixture(scope="module")
def on_the_table(parts):
    """Put an object on the table; return the cell and the grasp planner."""
    station = build_station(parts)
    start = station.get_state()

    def put(thing):
        station.set_state(start)
        station.cell.add(thing, ON_THE_TABLE, name="it")
        return station.cell, GraspPlanner(station.cell, station.arm)

    return put


def test_a_slippery_object_is_refused_with_the_coefficient_that_it_needs(on_the_table):
    cell, planner = on_the_table(Cube(mass=1.0, friction=0.05))
    gripper = planner.arm.robot.gripper
    check_friction(cell, gripper, "it")  # 140 N would hold it
    message = (
        "too little friction to hold 'it': 1 kg needs a friction coefficient of at least 0.0981 "
        "at 2 x 50 N; 'it' has 0.05"
    )
    with pytest.raises(MotionError, match=message) as raised:
        check_friction(cell, gripper, "it", 50.0)
    assert raised.value.reason == "grasp"
    with pytest.raises(GripperError, match="holds with up to 140 N, not 0 N"):
        check_friction(cell, gripper, "it", 0.0)


def test_no_grasp_is_planned_where_no_force_holds(on_the_table):
    cell, planner = on_the_table(Cube())
    planner.plan("it", [0.1], cell.pose("it").translation)
    cell.override("it", friction=0.001)
    for find in (
        lambda: planner.plan("it", [0.1], cell.pose("it").translation),
        lambda: planner.nearest("it", planner.arm.robot.tool_pose),
    ):
        with pytest.raises(MotionError, match="at least 0.00198 at 2 x 140 N; 'it' has 0.001"):
            find()


def test_what_is_fixed_needs_no_friction(on_the_table):
    cell, planner = on_the_table(Cube())
    cell.override("basket", friction=1e-6)
    check_friction(cell, planner.arm.robot.gripper, "basket", 1.0)


def test_grasps_follow_the_friction_as_it_changes(on_the_table):
    """The sides lean by 4.3 degrees, beyond 80 % of the cone of a friction of 0.05."""
    cell, planner = on_the_table(ConvexMesh())
    planner.plan("it", [0.1], cell.pose("it").translation)
    cell.override("it", friction=0.05)
    with pytest.raises(MotionError):
        planner.plan("it", [0.1], cell.pose("it").translation)
    cell.override("it", friction=None)
    planner.plan("it", [0.1], cell.pose("it").translation)
