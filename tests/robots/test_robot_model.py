import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Payload, Robot, compile_alone, panda


def test_the_jacobian_is_the_derivative_of_the_pose(model, rng):
    q = rng.uniform(model.limits.lower, model.limits.upper)
    h = 1e-6
    numeric = np.zeros((6, model.nq))
    for i in range(model.nq):
        dq = h * np.eye(model.nq)[i]
        ahead, behind = model.pose(q + dq), model.pose(q - dq)
        numeric[:3, i] = (ahead.translation - behind.translation) / (2 * h)
        numeric[3:, i] = pin.log3(ahead.rotation @ behind.rotation.T) / (2 * h)
    assert np.abs(model.jacobian(q) - numeric).max() < 1e-8


def test_the_effort_is_what_mujoco_needs_to_make_that_acceleration(rng):
    robot = Robot(panda(), gripper=TwoFingerGripper)
    compile_alone(robot)
    model = robot.make_model()
    q = rng.uniform(model.limits.lower, model.limits.upper)
    v, a = rng.standard_normal(7), rng.standard_normal(7)
    data = robot.mj_data
    robot.mj_model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    robot.mj_model.dof_frictionloss[robot.dof_adr] = 0.0  # MuJoCo's is a soft constraint
    data.qpos[:] = model.locked_qpos
    data.qpos[robot.qpos_adr] = q
    data.qvel[:] = 0.0
    data.qvel[robot.dof_adr] = v
    data.qacc[:] = 0.0
    data.qacc[robot.dof_adr] = a
    mujoco.mj_inverse(robot.mj_model, data)
    asked = model.effort(q, v, a) - model.friction * np.sign(v)
    assert np.abs(asked - data.qfrc_inverse[robot.dof_adr]).max() < 1e-9


@pytest.mark.parametrize("gravity", [(3.0, -2.0, 1.0), None])
def test_the_effort_at_rest_is_mujocos_bias_force_in_any_gravity(gravity, rng):
    robot, cell = Robot(panda()), Cell()
    if gravity is None:
        cell.arena.mjcf_model.option.flag.gravity = "disable"
    else:
        cell.arena.mjcf_model.option.gravity = gravity
    cell.add(robot, free=False)
    model, data = robot.make_model(), robot.mj_data
    q, still = rng.uniform(model.limits.lower, model.limits.upper), np.zeros(7)
    data.qpos[:] = model.locked_qpos
    data.qpos[robot.qpos_adr] = q
    data.qvel[:] = 0.0
    mujoco.mj_forward(robot.mj_model, data)
    bias = data.qfrc_bias[robot.dof_adr]
    assert np.abs(model.rnea(q, still, still) - bias).max() < 1e-9
    assert bool(np.abs(bias).max() > 1e-3) is (gravity is not None)


def test_a_payload_adds_its_weight_at_its_place(model, rng):
    q = rng.uniform(model.limits.lower, model.limits.upper)
    still = np.zeros(7)
    payload = Payload(2.0, [0.03, -0.02, 0.1])
    com = model.pose(q).act(payload.com)
    carrying = model.with_payload(payload)
    # Virtual work: the torque of a force at a point is the Jacobian there, transposed, times it.
    J = model.jacobian(q)
    at_com = J[:3] - pin.skew(com - model.pose(q).translation) @ J[3:]
    expected = at_com.T @ np.array([0.0, 0.0, 2.0 * 9.81])
    added = carrying.rnea(q, still, still) - model.rnea(q, still, still)
    assert np.abs(added - expected).max() < 1e-9


def test_a_payload_replaces_the_one_before_and_leaves_the_model_it_was_given_to(model):
    still = np.zeros(7)
    before = model.rnea(model.home, still, still + 1).copy()
    first = model.with_payload(Payload(3.0, [0.0, 0.1, 0.0], 0.1 * np.eye(3)))
    assert np.array_equal(model.rnea(model.home, still, still + 1), before)
    again = first.with_payload(Payload(1.0)).with_payload(None)
    assert again.payload is None
    assert np.abs(again.rnea(model.home, still, still + 1) - before).max() < 1e-12


def test_a_pose_given_out_does_not_change_afterwards(model):
    first = model.pose(model.home)
    kept = first.copy()
    model.pose(model.home + 0.1)
    assert first == kept


def test_the_static_force_takes_one_joint_to_its_limit(model, rng):
    q = rng.uniform(model.limits.lower, model.limits.upper)
    up = np.array([0.0, 0.0, 1.0])
    force, zero = model.static_force(q, up), np.zeros(model.nq)
    tau = model.rnea(q, zero, zero) + force * model.jacobian(q)[2]
    assert (np.abs(tau) / model.limits.effort).max() == pytest.approx(1.0)
