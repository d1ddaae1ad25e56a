from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.cell import Cell
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Payload, Robot, panda
from tests.robot_fixtures import compiled, described


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
    robot = compiled(panda(), gripper=TwoFingerGripper)
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


RAIL = """<mujoco><compiler angle="radian"/><worldbody><body pos="0.3 -0.2 0.5">
  <joint name="rail" type="slide" axis="0 1 0" range="-0.5 0.5" damping="3" frictionloss="2"/>
  <geom size="0.05"/><body pos="0 0 0.4">
    <joint name="shoulder" axis="0 1 0" range="-3 3" damping="0.5" frictionloss="0.7"/>
    <geom size="0.05"/><body pos="0.3 0 0">
      <joint name="elbow" axis="0 1 0" range="-3 3"/><geom size="0.05"/>
      <site name="tip" pos="0.12 0 0.16"/>
</body></body></body></worldbody></mujoco>"""


def test_lengths_losses_and_reach_of_an_arm_on_a_rail(tmp_path):
    (tmp_path / "rail.xml").write_text(RAIL)
    described_arm = replace(
        described(tmp_path / "rail.xml"), arm_joints=("rail", "shoulder", "elbow"),
        home=(0.0,) * 3, velocity=(1.0,) * 3, acceleration=(5.0,) * 3, jerk=(100.0,) * 3,
        effort=(50.0, 50.0, 20.0),
    )  # fmt: skip
    robot = compiled(described_arm)
    model = robot.make_model()
    assert model.units == ("m", "rad", "rad")
    assert model.link_lengths == pytest.approx([0.4, 0.3, 0.2])
    assert model.levers == pytest.approx([1.0, 0.5, 0.2])
    v = np.array([[0.01, -0.02, 0.5], [-0.003, 0.4, 0.01]])
    damping, dry, ratio = np.array([3.0, 0.5, 0.0]), np.array([2.0, 0.7, 0.0]), np.exp(200.0 * v)
    expected = damping * v + dry * (ratio - 1.0) / (ratio + 1.0)  # 76 % of it at 0.01 rad/s
    assert model.losses(v) == pytest.approx(expected)
    zero = np.zeros(3)
    assert np.array_equal(model.effort(zero, zero, zero), model.rnea(zero, zero, zero))
    # Upright at an end of the rail the tool is 0.9 m over the first joint and 0.5 m beside it.
    assert 0.95 * np.hypot(0.9, 0.5) < model.reach < np.hypot(0.9, 0.5)
    # Stretched out level, only the rail moves it along the rail, and only the joints move it up.
    level, ball = np.array([0.0, 0.0, np.arctan2(0.16, 0.12)]), 4 / 3 * np.pi * 0.05**3 * 1000.0
    assert model.static_force(level, np.array([0.0, 1.0, 0.0])) == pytest.approx(50.0)
    assert model.static_force(level, np.array([1.0, 0.0, 0.0])) == np.inf
    for mass in (0.1, 9.0, 12.0):
        shoulder, elbow = 50.0 - 9.81 * (0.3 * ball + 0.5 * mass), 20.0 - 9.81 * 0.2 * mass
        force = model.with_payload(Payload(mass)).static_force(level, np.array([0.0, 0.0, 1.0]))
        assert force == pytest.approx(max(min(shoulder / 0.5, elbow / 0.2), 0.0))


def test_the_static_force_takes_one_joint_to_its_limit(model, rng):
    q = rng.uniform(model.limits.lower, model.limits.upper)
    up = np.array([0.0, 0.0, 1.0])
    force, zero = model.static_force(q, up), np.zeros(model.nq)
    tau = model.rnea(q, zero, zero) + force * model.jacobian(q)[2]
    assert (np.abs(tau) / model.limits.effort).max() == pytest.approx(1.0)
