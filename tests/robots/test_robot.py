import dataclasses

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from dm_control import composer, mjcf

from bt_manip import spatial
from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import (
    Robot,
    RobotDescription,
    RobotError,
    compile_alone,
    panda,
)
from bt_manip_contracts import verify
from tests.robot_fixtures import compiled, described

SERVO_ARM = """
<mujoco model="servo">
  <compiler angle="radian"/>
  <option gravity="0 0 -3" timestep="0.005"/>
  <worldbody>
    <body name="upper" gravcomp="1">
      <joint name="shoulder" axis="0 1 0" range="-2 2" limited="true"/>
      <geom type="capsule" fromto="0 0 0 .3 0 0" size=".03"/>
      <body name="lower" pos=".3 0 0">
        <joint name="elbow" axis="0 1 0" range="-2 2" limited="true"/>
        <geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
        <site name="tip" pos=".3 0 0"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="p1" joint="shoulder" kp="100" forcerange="-20 20" forcelimited="true"/>
    <velocity joint="shoulder" kv="3" forcerange="-50 50" forcelimited="true"/>
    <motor name="m2" joint="elbow" ctrlrange="-7 7" ctrllimited="true"/>
  </actuator>
  <keyframe><key name="home" qpos="0 1"/></keyframe>
</mujoco>
"""


@pytest.fixture
def servo(tmp_path):
    path = tmp_path / "servo.xml"
    path.write_text(SERVO_ARM)
    return described(path)


def test_armature_of_the_description_replaces_the_models_in_both_models(servo):
    def mass_matrices(description: RobotDescription) -> tuple[np.ndarray, np.ndarray]:
        robot = compiled(description)
        mujoco.mj_forward(robot.mj_model, robot.mj_data)
        full = np.zeros((robot.mj_model.nv, robot.mj_model.nv))
        for i, unit in enumerate(np.eye(robot.mj_model.nv)):
            mujoco.mj_mulM(robot.mj_model, robot.mj_data, full[i], unit)
        model = robot.make_model()
        return full, pin.crba(model.model, model.data, robot.q)

    without, described = (
        mass_matrices(dataclasses.replace(servo, armature=given)) for given in (None, (0.3, 0.02))
    )
    for before, after in zip(without, described, strict=True):
        assert after - before == pytest.approx(np.diag([0.3, 0.02]), abs=1e-12)


def test_the_model_knows_where_the_robot_stands(rng):
    arena = composer.Arena()
    robot = Robot(panda(), gripper=TwoFingerGripper)
    frame = arena.attach(robot)
    frame.pos, frame.quat = [0.4, -0.2, 1.0], [0.9, 0.1, -0.3, 0.2]
    physics = mjcf.Physics.from_mjcf_model(arena.mjcf_model)
    for entity in robot.iter_entities():
        entity.after_compile(physics, None)
    model = robot.make_model()
    assert verify(robot.mj_model, model.model, rng=rng, qpos=model.locked_qpos).worst < 1e-9
    q = rng.uniform(robot.limits.lower, robot.limits.upper)
    robot.set_configuration(q)
    physics.forward()
    assert model.pose(q).isApprox(robot.tool_pose, 1e-9)


@pytest.mark.parametrize("frame", ["tool", "hand"])  # a site and a body
def test_the_tool_may_be_offset_from_its_frame_in_the_model(frame):
    T_ft = spatial.pose((0.02, -0.01, 0.05), (0.9, 0.1, -0.3, 0.2))
    at, off = (
        Robot(dataclasses.replace(panda(), tool_frame=frame, T_ft=T))
        for T in (pin.SE3.Identity(), T_ft)
    )
    for robot in (at, off):
        compile_alone(robot)
    assert off.tool_pose.isApprox(at.tool_pose * T_ft, 1e-9)
    assert off.make_model().pose(off.q).isApprox(off.tool_pose, 1e-9)


def test_a_gripper_class_is_ignored_for_a_description_without_a_gripper():
    assert (
        Robot(dataclasses.replace(panda(), gripper=None), gripper=TwoFingerGripper).gripper is None
    )


def test_an_episode_starts_at_home_with_the_gripper_open():
    robot = Robot(panda(), gripper=TwoFingerGripper)
    with pytest.raises(RobotError, match="not compiled yet"):
        robot.make_model()
    compile_alone(robot)
    q = robot.q
    assert np.allclose(q, robot.description.home)
    assert robot.mj_data.qpos[robot.gripper.mechanism.qpos_adr].sum() == pytest.approx(0.08)
    q[0] += 1.0
    assert robot.q[0] != q[0]  # it is a copy


def test_servos_become_motors_of_the_same_effort_and_the_world_of_the_file_is_left_out(servo):
    robot = Robot(servo)
    physics = compile_alone(robot)
    assert list(robot.limits.effort) == [20.0, 7.0]
    assert robot.mj_model.nu == 2
    for commanded, applied in (([3.0, -2.0], [3.0, -2.0]), ([100.0, -100.0], [20.0, -7.0])):
        robot.mj_data.ctrl[robot.ctrl_adr] = commanded
        mujoco.mj_forward(robot.mj_model, robot.mj_data)
        assert np.allclose(robot.tau, applied)
    assert physics.model.opt.gravity[2] == -9.81
    assert physics.model.nkey == 0
    assert not physics.model.body_gravcomp.any()


def test_effort_that_nothing_bounds_is_asked_for(servo, tmp_path):
    unbounded = tmp_path / "unbounded.xml"
    unbounded.write_text(SERVO_ARM.replace('ctrlrange="-7 7" ctrllimited="true"', ""))
    description = dataclasses.replace(servo, model=str(unbounded))
    with pytest.raises(RobotError, match="effort of elbow; give `effort` in the description"):
        Robot(description)
    assert list(Robot(dataclasses.replace(description, effort=(1.0, 2.0))).limits.effort) == [1, 2]


def test_the_robot_lives_in_a_plain_composer_environment():
    robot = Robot(panda(), gripper=TwoFingerGripper)
    robot.observables.enable_all()
    arena = composer.Arena()
    arena.attach(robot)
    environment = composer.Environment(composer.NullTask(arena), random_state=0)
    seen = environment.reset().observation
    assert np.allclose(seen["panda/joint_positions"], robot.description.home)
    assert np.allclose(seen["panda/tool_position"], robot.tool_pose.translation)
    assert seen["panda/tool_rotation"].size == 9 and seen["panda/tool_velocity"].size == 6
    for name, size in (("wrist_force", 3), ("wrist_torque", 3), ("joint_torques", 7)):
        assert seen[f"panda/{name}"].size == size
    environment.step(np.zeros(environment.action_spec().shape))
