"""Impedance control: damped springs between joints or tool and their reference."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.control import ControlError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip_impedance import CartesianImpedance, JointImpedance
from bt_manip_impedance.cartesian_impedance import REGULARISATION

REST = np.zeros(7)


def under_control(kind, *, friction=True, **gains):
    """Return the cell of a Panda, its controller and MuJoCo's bias forces at home."""
    robot = Robot(panda(), gripper=TwoFingerGripper)
    controller = kind(robot, **gains)
    robot.attach(controller)
    cell = Cell()
    cell.add(robot)
    if not friction:
        cell.model.dof_frictionloss[:] = 0.0
    fingers = robot.gripper.mechanism.qpos_adr
    cell.data.qpos[fingers] = controller.model.locked_qpos[fingers]  # where the model has them
    mujoco.mj_forward(cell.model, cell.data)
    return cell, controller, cell.data.qfrc_bias[robot.dof_adr].copy()


def mujoco_jacobian(cell: Cell, robot: Robot) -> np.ndarray:
    """Return MuJoCo's Jacobian of the tool: linear over angular."""  # (6, nq)
    linear, angular = np.zeros((3, cell.model.nv)), np.zeros((3, cell.model.nv))
    mujoco.mj_jacSite(cell.model, cell.data, linear, angular, robot.tool_site_id)
    return np.vstack((linear, angular))[:, robot.dof_adr]


def mujoco_inertia(cell: Cell, robot: Robot) -> np.ndarray:
    """Return MuJoCo's inertia matrix of the arm."""  # (nq, nq)
    M = np.zeros((cell.model.nv, cell.model.nv))
    for column, unit in zip(M, np.eye(cell.model.nv), strict=True):
        mujoco.mj_mulM(cell.model, cell.data, column, unit)
    return M[np.ix_(robot.dof_adr, robot.dof_adr)]


@pytest.mark.parametrize("kind", [JointImpedance, CartesianImpedance])
def test_on_the_reference_the_torque_is_that_of_bias_and_friction(kind):
    cell, controller, _ = under_control(kind)
    robot = controller.robot
    q, v = robot.q + 0.1, np.full(7, 0.3)
    dofs = robot.dof_adr
    cell.data.qpos[robot.qpos_adr], cell.data.qvel[dofs] = q, v
    mujoco.mj_forward(cell.model, cell.data)
    friction = cell.model.dof_damping[dofs] * v + cell.model.dof_frictionloss[dofs]
    tau = controller.compute(q, v, q, v, REST)
    np.testing.assert_allclose(tau, cell.data.qfrc_bias[dofs] + friction, atol=1e-9)


def test_off_the_reference_the_torque_is_stiffness_times_error():
    _, controller, bias = under_control(JointImpedance, stiffness=np.arange(100.0, 701.0, 100.0))
    q = controller.robot.q
    tau = controller.compute(q, REST, q + 0.01, REST, REST)
    np.testing.assert_allclose(tau - bias, np.arange(1.0, 8.0), atol=1e-9)


def test_an_external_torque_deflects_a_joint_by_torque_over_stiffness():
    cell, controller, _ = under_control(JointImpedance, stiffness=500.0)
    robot, joint = controller.robot, 3
    start = robot.q
    cell.data.qfrc_applied[robot.dof_adr[joint]] = 10.0
    cell.step(1500)
    dry = controller.model.friction[joint]  # it stops up to its dry friction early
    assert robot.q[joint] - start[joint] == pytest.approx(10.0 / 500.0, abs=dry / 500.0)


def test_damping_is_critical_for_the_inertia_of_each_joint():
    cell, controller, _ = under_control(JointImpedance, stiffness=400.0, damping_ratio=0.5)
    inertia = np.diag(mujoco_inertia(cell, controller.robot))
    damping = controller.damping(controller.robot.q)
    np.testing.assert_allclose(damping, 2 * 0.5 * np.sqrt(400.0 * inertia), rtol=1e-9)


def test_near_the_reference_the_wrench_is_stiffness_times_error():
    stiffness, turning = [100.0, 200.0, 300.0], [10.0, 20.0, 30.0]
    gains = {"stiffness": stiffness, "rotational_stiffness": turning, "posture_stiffness": 0.0}
    cell, controller, bias = under_control(CartesianImpedance, **gains)
    robot = controller.robot
    J = mujoco_jacobian(cell, robot)
    step = 1e-5 * np.array([1.0, -2.0, 0.5, 1.0, -1.0, 2.0, 1.0])
    spring = controller.compute(robot.q, REST, robot.q + step, REST, REST) - bias
    wrench = np.array(stiffness + turning) * (J @ step)
    np.testing.assert_allclose(spring, J.T @ wrench, atol=1e-3 * abs(spring).max())
    # The last joint turns the tool about its own z axis, which points down.
    error = controller.error(robot.q + 0.8 * np.eye(7)[6], robot.q)
    np.testing.assert_allclose(abs(error), [0, 0, 0, 0, 0, 0.8], atol=1e-6)


def test_posture_torques_do_not_accelerate_the_tool():
    gains = {"stiffness": 0.0, "rotational_stiffness": 0.0}
    cell, controller, bias = under_control(CartesianImpedance, **gains)
    robot = controller.robot
    posture = controller.compute(robot.q, REST, robot.q + 0.3, REST, REST) - bias
    assert abs(posture).max() > 0.5
    acceleration = np.linalg.solve(mujoco_inertia(cell, robot), posture)  # of the joints
    of_tool = mujoco_jacobian(cell, robot) @ acceleration
    assert np.linalg.norm(of_tool) < 0.02 * np.linalg.norm(acceleration)
    # Damped: c (M_inv + c)^-1 of the tool's acceleration remains, with its mobility M_inv.
    J_Minv = mujoco_jacobian(cell, robot) @ np.linalg.inv(mujoco_inertia(cell, robot))
    mobility = J_Minv @ mujoco_jacobian(cell, robot).T
    share = REGULARISATION * np.linalg.inv(mobility + REGULARISATION * np.eye(6))
    expected = share @ J_Minv @ np.full(7, 0.3 * controller.posture_stiffness)
    np.testing.assert_allclose(of_tool, expected, atol=1e-3 * np.linalg.norm(expected))


def test_a_force_deflects_the_tool_by_force_over_stiffness():
    cell, controller, _ = under_control(CartesianImpedance, stiffness=500.0, friction=False)
    robot, force = controller.robot, np.array([10.0, -8.0, 5.0])
    start, site = robot.tool_pose.translation.copy(), robot.tool_site_id
    body = cell.model.site_bodyid[site]
    for _ in range(1500):
        efforts, place = np.zeros(cell.model.nv), cell.data.site_xpos[site]
        mujoco.mj_applyFT(cell.model, cell.data, force, np.zeros(3), place, body, efforts)
        cell.data.qfrc_applied[:] = efforts
        cell.step()
    moved = robot.tool_pose.translation - start
    np.testing.assert_allclose(moved, force / 500.0, atol=5e-4)


def test_a_released_tool_returns_without_overshoot():
    cell, controller, _ = under_control(CartesianImpedance, friction=False)
    robot = controller.robot
    _ = controller.reference  # where it stands now
    start = robot.tool_pose.translation.copy()
    cell.data.qpos[robot.qpos_adr[3]] += 0.05
    mujoco.mj_forward(cell.model, cell.data)
    away = robot.tool_pose.translation - start
    course = []
    for _ in range(1500):
        cell.step()
        course.append((robot.tool_pose.translation - start) @ away / np.linalg.norm(away))
    assert np.linalg.norm(away) > 0.02
    assert abs(course[-1]) < 1e-4
    assert min(course) > -0.1 * np.linalg.norm(away)


@pytest.mark.parametrize(
    ("kind", "gains", "message"),
    [
        (JointImpedance, {"stiffness": -1.0}, "stiffness must be"),
        (JointImpedance, {"stiffness": [1.0, 2.0]}, "one for each of 7"),
        (JointImpedance, {"damping_ratio": float("nan")}, "damping_ratio must be"),
        (CartesianImpedance, {"stiffness": [1.0, 2.0]}, "one for each of 3"),
        (CartesianImpedance, {"rotational_stiffness": np.inf}, "rotational_stiffness must be"),
        (CartesianImpedance, {"posture_stiffness": -1.0}, "posture_stiffness must be"),
        (CartesianImpedance, {"damping_ratio": -1.0}, "damping_ratio must be"),
    ],
)
def test_impossible_gains_are_refused(kind, gains, message):
    with pytest.raises(ControlError, match=message):
        under_control(kind, **gains)
