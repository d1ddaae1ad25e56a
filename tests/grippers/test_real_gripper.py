"""A real gripper in the simulated cell: what it holds, from its flag and width."""

import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.cell.objects import Cube
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import GripperState, Robot, panda
from bt_manip.spatial import pose


class StubLink:
    restorable = True

    def start(self):
        self.state, self.busy, self.problem, self.sent = GripperState(0.08, False), False, "", []

    def command(self, kind, *arguments):
        self.sent.append((kind, *arguments))
        self.busy = True

    def done(self, width, is_grasped):
        self.state, self.busy = GripperState(width, is_grasped), False

    def update(self):
        pass


@pytest.fixture(scope="module")
def connection():
    return StubLink()


@pytest.fixture(scope="module")
def cell():
    return Cell()


@pytest.fixture(scope="module")
def built(cell, connection):
    connection.start()
    robot = Robot(panda(), gripper=TwoFingerGripper.on_device(connection))
    cell.add(robot)
    return robot, robot.gripper.get_state()


@pytest.fixture
def gripper(built, cell, connection):
    """Give the gripper at its start, around a cube."""
    robot, start = built
    connection.start()
    robot.gripper.set_state(start)
    cell.add(Cube(size=0.05), robot.tool_pose, name="cube", overlap=0.1)
    robot.gripper.follow_tool(robot.tool_pose)
    yield robot.gripper
    for name in {*cell.entities} - {"panda"}:
        cell.remove(name)


@pytest.fixture
def holding(gripper, connection):
    gripper.close(30.0)
    connection.done(0.049, True)
    gripper.update()
    return gripper


def test_it_holds_the_object_at_the_tool_which_moves_with_it_until_it_slips(
    holding, cell, connection
):
    assert holding.steady and holding.held == ("cube",) and holding.forces == (30.0, 30.0)
    assert holding.status == "fingers 49 of 80 mm apart"
    connection.problem = "no power"
    assert holding.status == "fingers 49 of 80 mm apart: no power"
    moved = pose((0.0, 0.1, 0.2)) * holding.robot.tool_pose
    holding.follow_tool(moved)
    np.testing.assert_allclose(cell.pose("cube").translation, moved.translation, atol=1e-6)
    assert holding.held_root() == cell.body_id("cube")
    for width in (0.0519, 0.0461, 0.0459):  # it slips by 3 mm; the vendor still says: gripped
        assert holding.held == ("cube",)
        connection.state = GripperState(width, True)
        holding.update()
    assert holding.held == () and holding.assumed == {"cube"} and holding.held_root() == 0


def test_it_holds_the_nearest_object_whatever_else_is_in_the_cell(cell, gripper, connection):
    cell.add(Cube(size=0.05), pose((0.5, 0.5, 0.5)), name="another")
    cell.add(Cube(size=0.05), gripper.robot.tool_pose, name="third", overlap=0.1)
    cell.remove("cube")
    gripper.close(30.0)
    connection.done(0.049, True)
    gripper.update()
    assert gripper.held == ("third",)
    turned = gripper.robot.tool_pose * pose((0, 0, 0), (0.8, 0.6, 0, 0))
    before = cell.pose("third")
    relative = gripper.robot.tool_pose.actInv(before)
    gripper.follow_tool(turned)
    assert cell.pose("third").isApprox(turned * relative, 1e-6)


def test_commands_take_time_and_nothing_is_held_without_the_flag_or_at_either_end(
    gripper, connection
):
    gripper.open()
    gripper.update()
    assert gripper.width == 0.08 and not gripper.is_open  # before the device says so
    connection.done(0.08, False)
    gripper.update()
    assert gripper.is_open
    connection.sent.clear()
    gripper.close(30.0)
    gripper.update()
    assert gripper.moving and not gripper.steady and not gripper.closed_on_nothing
    assert connection.sent == [("grasp", 0.0, 0.1, 30.0)]
    grasps = [(0.0029, True), (0.0031, True), (0.0789, True), (0.0791, True), (0.049, False)]
    for width, flag in grasps:
        held = flag and 0.003 < width < 0.079  # not at either end
        gripper.close(30.0)
        connection.done(width, flag)
        gripper.update()
        assert gripper.closed_on_nothing != held and gripper.forces == (30.0 * held,) * 2
        for opened in (0.0769, 0.0771):
            gripper.open()
            connection.done(opened, False)
            gripper.update()
            assert gripper.is_open == (opened > 0.077) and not gripper.held


@pytest.mark.parametrize(("away", "held"), [(0.099, ("cube",)), (0.101, ())])
def test_it_holds_nothing_farther_away_than_10_cm(gripper, cell, connection, away, held):
    T_wo = pose((0.6 * away, 0.0, 0.8 * away)) * gripper.robot.tool_pose
    cell.move("cube", T_wo, overlap=1.0)
    gripper.close(30.0)
    connection.done(0.049, True)
    gripper.update()
    assert gripper.held == held


@pytest.mark.parametrize(("measured", "shown"), [(0.03, 0.03), (-0.001, 0.0), (0.081, 0.08)])
def test_the_fingers_are_shown_where_they_are_measured(gripper, connection, measured, shown):
    connection.state = GripperState(measured, False)
    gripper.follow_tool(gripper.robot.tool_pose)
    positions = gripper.robot.mj_data.qpos[7:9]  # after those of the arm
    assert positions == pytest.approx([shown / 2] * 2, abs=1e-4)


def test_a_released_object_falls_before_the_gripper_counts_as_free(holding, connection):
    holding.open()
    connection.done(0.08, False)
    holding.update()
    assert holding.is_open and not holding.is_free and holding.assumed == {"cube"}
    for _ in range(50):
        assert not holding.is_free
        holding.follow_tool(holding.robot.tool_pose)
    assert holding.is_free
