"""Impedance control: damped springs between joints or tool and their reference."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell
from bt_manip.control import ControlError
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, panda
from bt_manip_impedance import CartesianImpedance, JointImpedance
from bt_manip_impedance.cartesian_impedance import REGULARISATION


def under_control(kind, **gains):
    """Return the cell of a Panda at home, and its controller."""
    robot = Robot(panda(), gripper=TwoFingerGripper)
    controller = kind(robot, **gains)
    robot.attach(controller)
    cell = Cell()
    cell.add(robot)
    fingers = robot.gripper.mechanism.qpos_adr
    cell.data.qpos[fingers] = controller.model.locked_qpos[fingers]  # where the model has them
    mujoco.mj_forward(cell.model, cell.data)
    return cell, controller


def moving(kind, **gains):
    """Return the torques beyond inverse dynamics in a random state, and MuJoCo's M and J there.

    Beside them the errors of the pose, the positions and the velocities.
    """
    cell, controller = under_control(kind, **gains)
    robot, rng = controller.robot, np.random.default_rng(3)
    dofs, data, model = robot.dof_adr, cell.data, cell.model
    q, v = robot.q + rng.uniform(-0.3, 0.3, 7), rng.uniform(-1.0, 1.0, 7)
    q_ref, a_ref = q + rng.uniform(-0.1, 0.1, 7), rng.uniform(-2.0, 2.0, 7)
    v_ref = rng.uniform(0.2, 1.0, 7) * (1, -1, 1, 1, -1, -1, 1)
    data.qpos[robot.qpos_adr] = q_ref
    mujoco.mj_kinematics(model, data)
    T_ref = robot.tool_pose
    data.qpos[robot.qpos_adr], data.qvel[dofs] = q, v
    mujoco.mj_forward(model, data)
    M, linear, angular = (np.zeros((rows, model.nv)) for rows in (model.nv, 3, 3))
    for column, unit in zip(M, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    mujoco.mj_jacSite(model, data, linear, angular, robot.tool_site_id)
    M, J, T = M[np.ix_(dofs, dofs)], np.vstack((linear, angular))[:, dofs], robot.tool_pose
    turn = pin.log3(T_ref.rotation @ T.rotation.T)  # about the world's axes
    losses = model.dof_damping[dofs] * v_ref + model.dof_frictionloss[dofs] * np.sign(v_ref)
    rest = M @ a_ref + data.qfrc_bias[dofs] + losses
    tau = controller.compute(q, v, q_ref, v_ref, a_ref)
    return (
        tau - rest,
        M,
        J,
        np.append(T_ref.translation - T.translation, turn),
        q_ref - q,
        v_ref - v,
    )


def test_joints_are_springs_with_the_same_damping_ratio_whatever_their_inertia():
    stiffness = np.arange(100.0, 701.0, 100.0)
    tau, M, _, _, error, v_error = moving(JointImpedance, stiffness=stiffness, damping_ratio=0.7)
    expected = stiffness * error + 2.0 * 0.7 * np.sqrt(stiffness * np.diag(M)) * v_error
    np.testing.assert_allclose(tau, expected, atol=1e-6)


def test_the_tool_is_held_by_springs_and_the_posture_by_others_that_do_not_accelerate_it():
    linear, angular = [100.0, 200.0, 300.0], [10.0, 20.0, 30.0]
    tau, M, J, error, q_error, v_error = moving(
        CartesianImpedance, stiffness=linear, rotational_stiffness=angular,
        posture_stiffness=15.0, damping_ratio=0.7,
    )  # fmt: skip
    stiffness, mobility = np.array(linear + angular), J @ np.linalg.inv(M) @ J.T
    damping = 2.0 * 0.7 * np.sqrt(stiffness / np.diag(mobility))  # along each axis, others free
    posture = 15.0 * q_error + 2.0 * 0.7 * np.sqrt(15.0 * np.diag(M)) * v_error
    wrench, pulled = stiffness * error + damping * (J @ v_error), J @ np.linalg.solve(M, posture)
    share = np.linalg.solve(mobility + REGULARISATION * np.eye(6), pulled)
    np.testing.assert_allclose(tau, J.T @ (wrench - share) + posture, atol=1e-6)
    of_tool = J @ np.linalg.solve(M, tau - J.T @ wrench)
    assert np.linalg.norm(of_tool) < 0.02 * np.linalg.norm(pulled)


def test_they_are_by_default_critically_damped_and_saturate_at_140_mrad():
    _, joints = under_control(JointImpedance)
    assert joints.stiffness == pytest.approx(joints.robot.limits.effort / (1 / 7))
    _, tool = under_control(CartesianImpedance)
    assert tool.stiffness == pytest.approx([1000.0] * 3 + [100.0] * 3)
    assert tool.posture_stiffness == 20.0 and tool.damping_ratio == joints.damping_ratio == 1.0


def test_a_force_deflects_the_tool_by_force_over_stiffness():
    cell, controller = under_control(CartesianImpedance, stiffness=500.0)
    cell.model.dof_frictionloss[:] = 0.0
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


def test_impossible_gains_are_refused():
    robot = Robot(panda())
    for kind, name, value, message in (
        (JointImpedance, "stiffness", -1.0, "stiffness must be"),
        (JointImpedance, "stiffness", [1.0, 2.0], "one for each of 7"),
        (JointImpedance, "damping_ratio", float("nan"), "damping_ratio must be"),
        (CartesianImpedance, "stiffness", [1.0, 2.0], "one for each of 3"),
        (CartesianImpedance, "rotational_stiffness", np.inf, "rotational_stiffness must be"),
        (CartesianImpedance, "posture_stiffness", -1.0, "posture_stiffness must be"),
        (CartesianImpedance, "damping_ratio", -1.0, "damping_ratio must be"),
    ):
        with pytest.raises(ControlError, match=message):
            kind(robot, **{name: value})
