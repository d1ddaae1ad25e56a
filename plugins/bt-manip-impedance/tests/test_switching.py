"""Switching between stiff and compliant control leaves the torques of the Panda continuous."""

from functools import cache

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.control import ComputedTorque, ControllerManager, Hold, Reference
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip_impedance import CartesianImpedance, JointImpedance

LARGEST_STEP = 0.02  # of the effort limit, beyond the step of a run without a switch
STEPS, SWITCHES = 1000, (400, 700)  # control steps: to the compliant controller, and back
FACTORIES = {
    "computed_torque": ComputedTorque,
    "joint_impedance": JointImpedance,
    "cartesian_impedance": CartesianImpedance,
}


class Ramp(Reference):
    """A reference that accelerates each joint to 1 rad/s in 0.3 s and keeps that speed."""

    ramp = 0.3  # [s]

    def __init__(self, q0):
        self.q0, self.t = np.array(q0), 0.0
        self.sign = np.array([1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0])
        self.advance(0.0)

    def advance(self, dt):
        self.t += dt
        T, u = self.ramp, min(self.t / self.ramp, 1.0)
        self.q = self.q0 + self.sign * (T * (u**3 - u**4 / 2) + max(0.0, self.t - T))
        self.v = self.sign * (3 * u**2 - 2 * u**3)
        self.a = self.sign * 6 * (u - u**2) / T


@cache
def torque_steps(*switches, moving, force):
    """Return the change of each joint's torque in each step, over its limit."""  # (STEPS - 1, 7)
    robot = Robot(panda(), gripper=TwoFingerGripper)
    manager = ControllerManager(robot, FACTORIES, "computed_torque")
    robot.attach(manager)
    cell = Cell()
    cell.add(robot)
    manager.reference = Ramp(robot.q) if moving else Hold(robot.q)
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
    ("moving", "force"),
    [(False, 30.0), (True, 0.0)],
    ids=["at rest under 30 N", "at 1 rad/s"],
)
def test_a_switch_moves_no_torque_beyond_what_the_reference_asks_for(compliant, moving, force):
    switches = zip(SWITCHES, (compliant, "computed_torque"), strict=True)
    switched = torque_steps(*switches, moving=moving, force=force)
    unswitched = torque_steps(moving=moving, force=force)
    beyond = np.abs(switched - unswitched)[SWITCHES[0] - 1 :]
    assert beyond.max() < LARGEST_STEP
