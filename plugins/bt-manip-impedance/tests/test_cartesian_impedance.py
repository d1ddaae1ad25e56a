"""Cartesian impedance control: damped springs between the tool and its reference."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.control import ControlError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip_impedance import CartesianImpedance


def under_control(*, friction=True, **gains) -> tuple[Cell, CartesianImpedance]:
    robot = Robot(panda(), gripper=TwoFingerGripper)
    controller = CartesianImpedance(robot, **gains)
    robot.attach(controller)
    cell = Cell()
    cell.add(robot)
    if not friction:
        cell.model.dof_frictionloss[:] = 0.0
    fingers = robot.gripper.mechanism.qpos_adr
    cell.data.qpos[fingers] = controller.model.locked_qpos[fingers]  # where the model has them
    mujoco.mj_forward(cell.model, cell.data)
    return cell, controller


def mujoco_jacobian(cell: Cell, robot: Robot) -> np.ndarray:
    """Return MuJoCo's Jacobian of the tool: linear over angular."""  # (6, nv)
    linear, angular = np.zeros((3, cell.model.nv)), np.zeros((3, cell.model.nv))
    mujoco.mj_jacSite(cell.model, cell.data, linear, angular, robot.tool_site_id)
    return np.vstack((linear, angular))[:, robot.dof_adr]


def test_on_the_reference_the_torque_is_that_of_bias_and_friction():
    cell, controller = under_control()
    robot = controller.robot
    q, v = robot.q + 0.1, np.full(7, 0.3)
    dofs = robot.dof_adr
    cell.data.qpos[robot.qpos_adr], cell.data.qvel[dofs] = q, v
    mujoco.mj_forward(cell.model, cell.data)
    friction = cell.model.dof_damping[dofs] * v + cell.model.dof_frictionloss[dofs]
    tau = controller.compute(q, v, q, v, np.zeros(7))
    np.testing.assert_allclose(tau, cell.data.qfrc_bias[dofs] + friction, atol=1e-9)


def test_near_the_reference_the_wrench_is_stiffness_times_error():
    stiffness, turning = [100.0, 200.0, 300.0], [10.0, 20.0, 30.0]
    cell, controller = under_control(
        stiffness=stiffness, rotational_stiffness=turning, posture_stiffness=0.0
    )
    robot, rest = controller.robot, np.zeros(7)
    J = mujoco_jacobian(cell, robot)
    step = 1e-5 * np.array([1.0, -2.0, 0.5, 1.0, -1.0, 2.0, 1.0])
    tau = controller.compute(robot.q, rest, robot.q + step, rest, rest)
    wrench = np.array(stiffness + turning) * (J @ step)
    spring = tau - cell.data.qfrc_bias[robot.dof_adr]
    np.testing.assert_allclose(spring, J.T @ wrench, atol=1e-3 * abs(spring).max())


def test_a_rotation_error_is_about_its_own_axis():
    cell, controller = under_control()
    robot = controller.robot
    q_ref = robot.q
    q = q_ref.copy()
    q[6] += 0.8  # the last joint turns the tool about its own z axis, which points down
    error = controller.error(q, q_ref)
    np.testing.assert_allclose(abs(error), [0, 0, 0, 0, 0, 0.8], atol=1e-6)


def test_posture_torques_do_not_accelerate_the_tool():
    cell, controller = under_control(stiffness=0.0, rotational_stiffness=0.0)
    robot, rest = controller.robot, np.zeros(7)
    tau = controller.compute(robot.q, rest, robot.q + 0.3, rest, rest)
    posture = np.zeros(cell.model.nv)
    posture[robot.dof_adr] = tau - cell.data.qfrc_bias[robot.dof_adr]
    assert abs(posture).max() > 0.5
    # The arm's own accelerations, with the fingers held still: MuJoCo's inertia of its joints.
    M = np.zeros((cell.model.nv, cell.model.nv))
    for i in range(cell.model.nv):
        mujoco.mj_mulM(cell.model, cell.data, M[i], np.eye(cell.model.nv)[i])
    M = M[np.ix_(robot.dof_adr, robot.dof_adr)]
    acceleration = mujoco_jacobian(cell, robot) @ np.linalg.solve(M, posture[robot.dof_adr])
    free = np.linalg.norm(np.linalg.solve(M, posture[robot.dof_adr]))
    assert np.linalg.norm(acceleration) < 0.02 * free


@pytest.mark.parametrize("axis", range(3))
def test_a_force_deflects_the_tool_by_force_over_stiffness(axis):
    cell, controller = under_control(stiffness=500.0, friction=False)
    robot = controller.robot
    start = robot.tool_pose.translation.copy()
    push = 10.0 * np.eye(3)[axis]
    for _ in range(1500):
        efforts = np.zeros(cell.model.nv)
        body = cell.model.site_bodyid[robot.tool_site_id]
        place = cell.data.site_xpos[robot.tool_site_id]
        mujoco.mj_applyFT(cell.model, cell.data, push, np.zeros(3), place, body, efforts)
        cell.data.qfrc_applied[:] = efforts
        cell.step()
    moved = robot.tool_pose.translation - start
    np.testing.assert_allclose(moved, push / 500.0, atol=5e-4)


def test_a_released_tool_returns_without_overshoot():
    cell, controller = under_control(friction=False)
    robot = controller.robot
    _ = controller.reference  # where it stands now
    start = robot.tool_pose.translation.copy()
    cell.data.qpos[robot.qpos_adr[3]] += 0.05
    mujoco.mj_forward(cell.model, cell.data)
    away = robot.tool_pose.translation - start
    direction = away / np.linalg.norm(away)
    course = []
    for _ in range(1500):
        cell.step()
        course.append((robot.tool_pose.translation - start) @ direction)
    assert np.linalg.norm(away) > 0.02
    assert abs(course[-1]) < 1e-4
    assert min(course) > -0.1 * np.linalg.norm(away)


@pytest.mark.parametrize(
    ("gains", "message"),
    [
        ({"stiffness": -1.0}, "stiffness must be"),
        ({"stiffness": [1.0, 2.0]}, "one for each of 3"),
        ({"rotational_stiffness": float("inf")}, "rotational_stiffness must be"),
        ({"posture_stiffness": -1.0}, "posture_stiffness must be"),
        ({"damping_ratio": -1.0}, "damping_ratio must be"),
    ],
)
def test_impossible_gains_are_refused(gains, message):
    with pytest.raises(ControlError, match=message):
        under_control(**gains)
