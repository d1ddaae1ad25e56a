"""Switching between stiff and compliant control leaves the torques of the Panda continuous."""

from functools import cache

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.control import ComputedTorque, ControllerManager, Hold
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip_impedance import CartesianImpedance, JointImpedance
from tests.support.arms import Wave

LARGEST_STEP = 0.02  # of the effort limit, beyond the step of a run without a switch
STEPS, SWITCHES = 1000, (400, 700)  # control steps: to the compliant controller, and back
FACTORIES = {
    "computed_torque": ComputedTorque,
    "joint_impedance": JointImpedance,
    "cartesian_impedance": CartesianImpedance,
}


@cache
def torque_steps(*switches, moving, force):
    """Return the change of each joint's torque in each step, over its limit."""  # (STEPS - 1, 7)
    robot = Robot(panda(), gripper=TwoFingerGripper)
    manager = ControllerManager(robot, FACTORIES, "computed_torque")
    robot.attach(manager)
    cell = Cell()
    cell.add(robot)
    # At both switches it moves at 0.9 rad/s, at most at 1 rad/s.
    manager.reference = Wave(robot.q, 0.35, 2.86) if moving else Hold(robot.q)
    rows = []
    for i in range(STEPS):
        for _, controller in filter(lambda switch: switch[0] == i, switches):
            manager.switch(controller)
        applied = np.zeros(cell.model.nv)
        tool = cell.data.site_xpos[robot.tool_site_id]
        body = cell.model.site_bodyid[robot.tool_site_id]
        mujoco.mj_applyFT(
            cell.model, cell.data, np.array([0.0, 0.0, force]), np.zeros(3), tool, body, applied
        )
        cell.data.qfrc_applied[:] = applied
        cell.step()
        rows.append(manager.controller.tau.copy())
    return np.diff(rows, axis=0) / robot.limits.effort


@pytest.mark.parametrize("compliant", ["joint_impedance", "cartesian_impedance"])
@pytest.mark.parametrize(
    ("moving", "force"), [(False, 30.0), (True, 0.0)], ids=["at rest under 30 N", "at 1 rad/s"]
)
def test_a_switch_moves_no_torque_beyond_what_the_reference_asks_for(compliant, moving, force):
    switches = zip(SWITCHES, (compliant, "computed_torque"), strict=True)
    switched = torque_steps(*switches, moving=moving, force=force)
    unswitched = torque_steps(moving=moving, force=force)
    beyond = np.abs(switched - unswitched)[SWITCHES[0] - 1 :]
    assert beyond.max() < LARGEST_STEP
