"""The controller follows its reference and fulfils the contract of controllers."""

import numpy as np
from bt_manip.cell import Cell
from bt_manip.robots import Robot, panda
from bt_manip_contracts import contracts_of

from bt_manip_gear.gear import Gear

test_contracts = contracts_of("gear")


def test_off_its_reference_the_joints_accelerate_by_kp_times_the_error():
    robot = Robot(panda())
    controller = Gear(robot, kp=400.0)
    robot.attach(controller)
    Cell().add(robot)
    q, rest = robot.q, np.zeros(7)
    tau = controller.compute(q, rest, q + 0.01, rest, rest)
    expected = controller.model.rnea(q, rest, np.full(7, 4.0))  # 400 / s2 times 0.01 rad
    np.testing.assert_allclose(tau, expected, atol=1e-9)
