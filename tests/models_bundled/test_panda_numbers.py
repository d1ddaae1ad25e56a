"""The Panda has the published kinematics, limits and inertias."""

from math import pi

import mujoco
import numpy as np
import pytest

# Craig's convention: a [m], d [m], alpha [rad] before each joint, and the flange after the last.
DH = [
    (0.0, 0.333, 0.0),
    (0.0, 0.0, -pi / 2),
    (0.0, 0.316, pi / 2),
    (0.0825, 0.0, pi / 2),
    (-0.0825, 0.384, -pi / 2),
    (0.0, 0.0, pi / 2),
    (0.088, 0.0, pi / 2),
]
FLANGE = 0.107

# Gaz et al., RA-L 2019: mass [kg], centre of mass [m], xx yy zz xy xz yz about it [kg m2].
INERTIAS = {
    "link0": (0.629769, (-0.041018, -0.00014, 0.049974),
              (0.00315, 0.00388, 0.004285, 8.2904e-07, 0.00015, 8.2299e-06)),
    "link1": (4.970684, (0.003875, 0.002081, -0.04762),
              (0.70337, 0.70661, 0.009117, -0.000139, 0.006772, 0.019169)),
    "link2": (0.646926, (-0.003141, -0.02872, 0.003495),
              (0.007962, 0.02811, 0.025995, -0.003925, 0.010254, 0.000704)),
    "link3": (3.228604, (0.027518, 0.039252, -0.066502),
              (0.037242, 0.036155, 0.01083, -0.004761, -0.011396, -0.012805)),
    "link4": (3.587895, (-0.05317, 0.104419, 0.027454),
              (0.025853, 0.019552, 0.028323, 0.007796, -0.001332, 0.008641)),
    "link5": (1.225946, (-0.011953, 0.041065, -0.038437),
              (0.035549, 0.029474, 0.008627, -0.002117, -0.004037, 0.000229)),
    "link6": (1.666555, (0.060149, -0.014117, -0.010517),
              (0.001964, 0.004354, 0.005433, 0.000109, -0.001158, 0.000341)),
    "link7": (0.735522, (0.010517, -0.004252, 0.061597),
              (0.012516, 0.010027, 0.004815, -0.000428, -0.001196, -0.000741)),
    "hand": (0.73, (-0.01, 0, 0.03), (0.001, 0.0025, 0.0017, 0, 0, 0)),
    "left_finger": (0.015, (0, 0, 0), (2.375e-06, 2.375e-06, 7.5e-07, 0, 0, 0)),
    "right_finger": (0.015, (0, 0, 0), (2.375e-06, 2.375e-06, 7.5e-07, 0, 0, 0)),
}  # fmt: skip


def dh_transform(a: float, d: float, alpha: float, theta: float) -> np.ndarray:
    """Return the pose of a frame in the one before it (Craig, eq. 3.6)."""
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    return np.array([
        [ct, -st, 0, a],
        [st * ca, ct * ca, -sa, -sa * d],
        [st * sa, ct * sa, ca, ca * d],
        [0, 0, 0, 1],
    ])  # fmt: skip


def test_frames_are_those_of_the_published_dh_table(panda):
    rng = np.random.default_rng(7)
    data = mujoco.MjData(panda)
    lower, upper = panda.jnt_range.T
    for _ in range(40):
        data.qpos = rng.uniform(lower, upper)
        mujoco.mj_kinematics(panda, data)
        pose = np.eye(4)
        for i, ((a, d, alpha), theta) in enumerate(zip(DH, data.qpos[:7], strict=True), start=1):
            pose = pose @ dh_transform(a, d, alpha, theta)
            body = data.body(f"link{i}")
            np.testing.assert_allclose(body.xpos, pose[:3, 3], atol=1e-9)
            np.testing.assert_allclose(body.xmat.reshape(3, 3), pose[:3, :3], atol=1e-9)
        flange = pose @ dh_transform(0, FLANGE, 0, 0)
        np.testing.assert_allclose(data.site("flange").xpos, flange[:3, 3], atol=1e-9)
        hand = flange @ dh_transform(0, 0, 0, -pi / 4)
        np.testing.assert_allclose(data.body("hand").xpos, hand[:3, 3], atol=1e-9)
        tool = hand @ dh_transform(0, 0.1034, 0, 0)
        np.testing.assert_allclose(data.site("tool").xpos, tool[:3, 3], atol=1e-9)
        np.testing.assert_allclose(data.site("tool").xmat.reshape(3, 3), tool[:3, :3], atol=1e-9)
        for side, opened in zip((1, -1), data.qpos[7:], strict=True):
            finger = hand @ [0, side * opened, 0.0584, 1]
            name = "left_finger" if side == 1 else "right_finger"
            np.testing.assert_allclose(data.body(name).xpos, finger[:3], atol=1e-9)


def test_masses_and_inertias_are_the_identified_ones_and_no_other_body_weighs_anything(panda):
    for name, (mass, com, (xx, yy, zz, xy, xz, yz)) in INERTIAS.items():
        body = panda.body(name)
        assert body.mass[0] == pytest.approx(mass, rel=1e-12)
        np.testing.assert_allclose(body.ipos, com, atol=1e-12)
        axes = np.empty(9)
        mujoco.mju_quat2Mat(axes, body.iquat)
        axes = axes.reshape(3, 3)
        tensor = axes @ np.diag(body.inertia) @ axes.T
        np.testing.assert_allclose(tensor, [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]], atol=1e-12)
    assert {panda.body(i).name for i in np.flatnonzero(panda.body_mass)} == set(INERTIAS)


def test_limits_friction_damping_and_armature_of_joints_are_the_published_ones(panda):
    arm = [panda.joint(f"joint{i}") for i in range(1, 8)]
    lower = (-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973)
    upper = (2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973)
    assert [tuple(joint.range) for joint in arm] == list(zip(lower, upper, strict=True))
    fingers = [panda.joint(f"finger_joint{i}") for i in (1, 2)]
    assert [tuple(joint.range) for joint in fingers] == [(0, 0.04)] * 2
    assert panda.jnt_limited.all()
    damping = (0.0665, 0.1987, 0.0399, 0.2257, 0.1023, 0, 0.0638)
    friction = (0.2450, 0.1523, 0.1827, 0.3591, 0.2669, 0.1658, 1.2109)
    np.testing.assert_array_equal(panda.dof_damping[:7], damping)
    np.testing.assert_array_equal(panda.dof_frictionloss[:7], friction)
    np.testing.assert_array_equal(panda.dof_armature, 0.1)


def test_actuators_are_torques_up_to_the_effort_limits(panda):
    names = [panda.actuator(i).name for i in range(panda.nu)]
    assert names == [f"motor{i}" for i in range(1, 8)] + ["finger1", "finger2"]
    driven = [panda.joint(panda.actuator_trnid[i, 0]).name for i in range(panda.nu)]
    assert driven == [f"joint{i}" for i in range(1, 8)] + ["finger_joint1", "finger_joint2"]
    efforts = np.array([87.0] * 4 + [12.0] * 3 + [140.0] * 2)
    for ranges in (panda.actuator_ctrlrange, panda.actuator_forcerange):
        np.testing.assert_array_equal(ranges, np.stack([-efforts, efforts], axis=1))
    assert panda.actuator_ctrllimited.all() and panda.actuator_forcelimited.all()
    assert (panda.actuator_gaintype == mujoco.mjtGain.mjGAIN_FIXED).all()
    assert (panda.actuator_biastype == mujoco.mjtBias.mjBIAS_NONE).all()
    np.testing.assert_array_equal(panda.actuator_gainprm[:, 0], 1)
    np.testing.assert_array_equal(panda.actuator_gear[:, 0], 1)
    assert not panda.body_gravcomp.any()  # it is left to the controller


def test_the_wrist_camera_sees_the_tool_between_the_fingers(panda):
    data = mujoco.MjData(panda)
    mujoco.mj_forward(panda, data)
    camera = data.camera("wrist")
    x, y, z = camera.xmat.reshape(3, 3).T @ (data.site("tool").xpos - camera.xpos)
    assert x == pytest.approx(0, abs=1e-9)
    assert z < 0  # a camera looks along its -z
    half = np.radians(panda.camera("wrist").fovy[0]) / 2
    assert abs(np.arctan2(y, -z)) < half
    looking = -camera.xmat.reshape(3, 3)[:, 2]
    along = data.site("tool").xmat.reshape(3, 3)[:, 2]
    assert looking @ along > np.cos(np.radians(20))
