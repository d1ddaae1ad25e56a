"""Joint impedance control: damped springs between the joints and their reference."""

from collections.abc import Callable

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.control import ControlError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip_impedance import JointImpedance


def under_control(**gains) -> tuple[Cell, JointImpedance]:
    robot = Robot(panda(), gripper=TwoFingerGripper)
    controller = JointImpedance(robot, **gains)
    robot.attach(controller)
    cell = Cell()
    cell.add(robot)
    return cell, controller


def at(cell: Cell, q: np.ndarray, v: np.ndarray, controller: JointImpedance) -> np.ndarray:
    """Set the arm's state and return MuJoCo's bias forces."""  # (nv,)
    robot = controller.robot
    fingers = robot.gripper.mechanism.qpos_adr
    cell.data.qpos[fingers] = controller.model.locked_qpos[fingers]  # where the model has them
    cell.data.qpos[robot.qpos_adr] = q
    cell.data.qvel[robot.dof_adr] = v
    mujoco.mj_forward(cell.model, cell.data)
    return cell.data.qfrc_bias[robot.dof_adr].copy()


@pytest.fixture(scope="module")
def make() -> Callable[..., tuple[Cell, JointImpedance]]:
    return under_control


def test_on_the_reference_the_torque_is_that_of_bias_and_friction(make):
    cell, controller = make()
    q, v = controller.robot.q + 0.1, np.full(7, 0.3)
    dofs = controller.robot.dof_adr
    friction = cell.model.dof_damping[dofs] * v + cell.model.dof_frictionloss[dofs]
    bias = at(cell, q, v, controller)
    tau = controller.compute(q, v, q, v, np.zeros(7))
    np.testing.assert_allclose(tau, bias + friction, atol=1e-9)


def test_off_the_reference_the_torque_is_stiffness_times_error(make):
    cell, controller = make(stiffness=[100.0 * i for i in range(1, 8)])
    q, rest = controller.robot.q, np.zeros(7)
    bias = at(cell, q, rest, controller)
    tau = controller.compute(q, rest, q + 0.01, rest, rest)
    np.testing.assert_allclose(tau - bias, np.arange(1.0, 8.0), atol=1e-9)


def test_an_external_torque_deflects_a_joint_by_torque_over_stiffness(make):
    cell, controller = make(stiffness=500.0)
    robot, joint = controller.robot, 3
    start = robot.q
    cell.data.qfrc_applied[robot.dof_adr[joint]] = 10.0
    cell.step(1500)
    dry = controller.model.friction[joint]  # it stops up to its dry friction early
    assert robot.q[joint] - start[joint] == pytest.approx(10.0 / 500.0, abs=dry / 500.0)


def test_damping_is_critical_for_the_inertia_of_each_joint(make):
    cell, controller = make(stiffness=400.0, damping_ratio=0.5)
    q = controller.robot.q
    at(cell, q, np.zeros(7), controller)
    full = np.zeros((cell.model.nv, cell.model.nv))
    for i in range(cell.model.nv):  # columns of MuJoCo's own inertia matrix
        unit = np.zeros(cell.model.nv)
        unit[i] = 1.0
        mujoco.mj_mulM(cell.model, cell.data, full[i], unit)
    inertia = full[controller.robot.dof_adr, controller.robot.dof_adr]
    np.testing.assert_allclose(controller.damping(q), 2 * 0.5 * np.sqrt(400.0 * inertia), rtol=1e-9)


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"stiffness": -1.0}, "stiffness must be"),
        ({"stiffness": [1.0, 2.0]}, "one for each of 7"),
        ({"damping_ratio": float("nan")}, "damping_ratio must be"),
    ],
)
def test_impossible_gains_are_refused(make, gains, message):
    with pytest.raises(ControlError, match=message):
        make(**gains)
