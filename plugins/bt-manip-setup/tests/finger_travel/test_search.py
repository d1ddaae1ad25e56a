"""Fingers are found in a compiled model, whatever moves them."""

from dataclasses import replace
from itertools import product

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from numpy.polynomial import Polynomial

from bt_manip.robots import Robot, RobotError, panda
from bt_manip_setup.finger_travel import OverlappingHullsError, find_fingers, search

from .mechanisms import ARM, MECHANISMS, model_of

PANDA = tuple(f"joint{i}" for i in range(1, 8))


@pytest.mark.parametrize("kind", MECHANISMS)
def test_fingers_of_every_kind_are_found(kind):
    mechanism = MECHANISMS[kind]
    found = find_fingers(mujoco.MjModel.from_xml_string(model_of(kind)), ARM)
    assert set(found.fingers) == set(mechanism.fingers)
    assert found.body == "palm" and found.motor == mechanism.motor
    assert len(found.joints) == (1 if found.motor else 2)
    # Half way along pads of 20 mm whose tips are 120 mm from the palm; they close along y.
    assert found.T_bt.translation == pytest.approx((0.0, mechanism.centre, 0.11), abs=1e-3)
    assert found.T_bt.rotation[:, 2] == pytest.approx((0, 0, 1), abs=1e-9)
    assert abs(found.T_bt.rotation[1, 1]) == pytest.approx(1.0, abs=1e-9)
    assert found.travel.min_width == pytest.approx(mechanism.closed, abs=2e-4)
    assert found.travel.open_width == pytest.approx(mechanism.opened, rel=0.05)
    assert found.travel.one_moves == mechanism.one_moves
    if mechanism.force is None:
        assert found.max_force is None
    else:
        assert found.max_force == pytest.approx(mechanism.force, rel=0.05)


def test_the_measured_openings_do_not_depend_on_the_pose_of_the_arm():
    turned = model_of("coupled_slides").replace('pos="0 0 1"', 'pos="0 0 1" euler="30 20 10"')
    found, other = (
        find_fingers(mujoco.MjModel.from_xml_string(xml), ARM)
        for xml in (model_of("coupled_slides"), turned)
    )
    assert np.allclose(found.T_bt.homogeneous, other.T_bt.homogeneous, atol=1.1e-3)
    assert found.travel.open_width == pytest.approx(other.travel.open_width, abs=1e-6)


def test_the_loss_of_a_finger_is_the_power_that_its_joints_dissipate():
    xml = model_of("hinges").replace('armature="0.002"', 'armature="0.002" damping="0.3"')
    model = mujoco.MjModel.from_xml_string(xml)
    travel = find_fingers(model, ARM).travel
    middle, speed = len(travel.widths) // 2, 0.1  # [m/s] of each finger
    data = mujoco.MjData(model)
    for name, positions in zip(travel.joints, travel.positions, strict=True):
        slope = np.gradient(positions, 0.5 * np.array(travel.widths))[middle]
        data.joint(name).qpos, data.joint(name).qvel = positions[middle], slope * speed
    mujoco.mj_forward(model, data)
    power = -float(data.qfrc_damper @ data.qvel)  # [W] of two fingers
    assert 2.0 * travel.loss * speed**2 == pytest.approx(power, rel=0.02)


def test_the_hand_of_the_panda_is_found():
    found = find_fingers(Robot(panda()).alone, PANDA)
    assert set(found.fingers) == {"left_finger", "right_finger"} and found.body == "hand"
    assert found.joints == ("finger_joint1", "finger_joint2") and found.motor is None
    assert found.T_bt.translation == pytest.approx((0.0, 0.0, 0.1034), abs=1e-3)
    assert np.allclose(found.T_bt.rotation, np.eye(3))
    assert (found.travel.min_width, found.travel.open_width) == (0.0, 0.08)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</worldbody>", "</worldbody>", "no joints beyond the arm's last one, 'turn'"),
        (
            "<!--palm-->",
            '<body><joint name="a"/><geom size="0.01"/></body>'
            '<body><joint name="b"/><geom size="0.01"/></body>'
            '<body><joint name="c"/><geom size="0.01"/></body>',
            "3 joints beyond 'turn' move independently: 'a', 'b', 'c'",
        ),
        (
            "<!--palm-->",
            '<body><joint name="a"/><geom size="0.01"/></body>',
            "without a range: 'a'",
        ),
        (
            "<!--palm-->",
            '<body pos="0 0 0.1"><joint name="a" range="0 1" limited="true"/>'
            '<geom size="0.01"/></body>',
            "no two surfaces .* open and close by more than 2 mm$",
        ),
        (
            "<!--palm-->",
            '<body name="jaw" pos="0 0 0.1"><joint name="a" range="0 1" limited="true"/>'
            '<geom size="0.01" contype="0" conaffinity="0"/></body>',
            "by more than 2 mm; give a collision geometry to the bodies without one: 'jaw'$",
        ),
    ],
)
def test_what_is_no_gripper_of_two_fingers_is_said(old, new, message):
    model = mujoco.MjModel.from_xml_string(model_of("none").replace(old, new))
    with pytest.raises(RobotError, match=message):
        find_fingers(model, ARM)


def test_meshes_that_overlap_where_the_fingers_are_open_need_convex_parts(monkeypatch):
    """Boxes would not become smaller by parts."""
    measure = search.measure_travel

    def overlapping(*bench, **named):
        return replace(measure(*bench, **named), open_width=-0.002)

    monkeypatch.setattr(search, "measure_travel", overlapping)
    boxes = model_of("coupled_slides")
    sides = product((-0.01, 0.01), (-0.004, 0.004), (-0.01, 0.01))
    corners = " ".join(f"{x} {y} {z}" for x, y, z in sides)
    mesh = f'<asset><mesh name="hull" vertex="{corners}"/></asset><worldbody>'
    pad = 'type="box" size="0.01 0.004 0.01"'
    meshes = boxes.replace("<worldbody>", mesh).replace(pad, 'type="mesh" mesh="hull"')
    with pytest.raises(OverlappingHullsError, match="overlap by 2.0 mm where they are open: a mes"):
        find_fingers(mujoco.MjModel.from_xml_string(meshes), ARM)
    with pytest.raises(RobotError, match="they open to -2 mm there"):
        find_fingers(mujoco.MjModel.from_xml_string(boxes), ARM)


def linked(name: str, side: int, joint: str) -> str:
    """Return a pad on a link of its own; both slide together, 40 mm open on each side."""
    inwards = -0.005 if side > 0 else 3e-4  # by which a link reaches beyond its pad
    return f"""
    <body name="{name}_link" pos="0 {0.044 * side} 0.1">
      <joint name="{joint}" type="slide" axis="0 {side} 0" range="-0.04 0" armature="0.1"/>
      <geom type="box" size="0.01 0.004 0.01" pos="0 {-side * inwards} -0.02"/>
      <body name="{name}_pad"><geom class="pad"/></body>
    </body>"""


def test_the_pads_are_two_bodies_of_the_same_kind():
    """The link under one pad reaches a little farther than the pad itself."""
    palm = linked("left", 1, "a") + linked("right", -1, "b")
    xml = model_of("coupled_slides")
    start, end = xml.index('<body name="left"'), xml.index("<!--palm-->")
    xml = xml[:start] + palm + xml[end:]
    equality = '<equality><joint joint1="a" joint2="b"/></equality>'
    start, end = xml.index("</worldbody>"), xml.index("<actuator>")
    motors = '<actuator><motor joint="a" ctrlrange="-20 20"/></actuator></mujoco>'
    xml = f"{xml[:start]}</worldbody>{equality}{motors}"
    found = find_fingers(mujoco.MjModel.from_xml_string(xml), ARM)
    assert set(found.fingers) == {"left_pad", "right_pad"}


def test_a_given_tool_frame_is_measured_and_turned_and_has_to_be_between_the_fingers():
    model = mujoco.MjModel.from_xml_string(model_of("coupled_slides"))
    at = np.array([0.0, 0.0, 0.115])
    turned = pin.SE3(pin.rpy.rpyToMatrix(0.0, np.pi / 2, 0.0), at)
    for T, rotation in ((pin.SE3(np.eye(3), at), np.eye(3)), (turned, None)):
        found = find_fingers(model, ARM, tool=("palm", T))
        assert found.T_bt.translation == pytest.approx(at)
        assert found.T_bt.rotation[:, 2] == pytest.approx((0, 0, 1))
        assert rotation is None or np.allclose(found.T_bt.rotation, rotation)
    with pytest.raises(RobotError, match=r"moves with 'left'; .*, 'palm'"):
        find_fingers(model, ARM, tool=("left", pin.SE3.Identity()))
    beyond = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.2]))
    with pytest.raises(RobotError, match="not between the fingers"):
        find_fingers(model, ARM, tool=("palm", beyond))


def test_a_hand_that_tendons_pull_is_not_taken_for_two_fingers():
    xml = model_of("coupled_slides")
    sites, tendons, motors = "", "", ""
    for i in range(3):
        sites += f'<site name="s{i}" pos="0 0 0.0{i}"/>'
        tendons += f'<spatial name="t{i}"><site site="base"/><site site="s{i}"/></spatial>'
        motors += f'<motor tendon="t{i}"/>'
    xml = xml.replace("<!--palm-->", '<site name="base"/><!--palm-->', 1)
    xml = xml.replace('<body name="left"', f'<body name="nail">{sites}</body><body name="left"', 1)
    xml = xml.replace("</worldbody>", f"</worldbody><tendon>{tendons}</tendon>")
    xml = xml.replace("</actuator>", f"{motors}</actuator>")
    with pytest.raises(RobotError, match="3 actuators pull on tendons beyond 'turn'"):
        find_fingers(mujoco.MjModel.from_xml_string(xml), ARM)


def test_the_mass_of_a_jaw_is_near_its_least_over_the_openings():
    """A position loop for a mass many times the real one would be unstable."""
    model = mujoco.MjModel.from_xml_string("""
    <mujoco><compiler angle="radian"/><worldbody><body name="palm">
      <joint name="turn" axis="1 0 0" range="-3 3" armature="0.1"/>
      <geom type="box" size="0.01 0.045 0.015" pos="0.01 0.015 0" mass="0.1"/>
      <geom type="box" size="0.04 0.005 0.01" pos="0.06 -0.025 0" mass="0.1"/>
      <body name="jaw" pos="0.035 0.01 0">
        <joint name="jaw" axis="0 0 1" range="-0.45 1.2"/>
        <geom type="box" size="0.035 0.005 0.01" pos="0.035 0 0" mass="0.05"/>
      </body></body></worldbody></mujoco>""")
    travel = find_fingers(model, ("turn",)).travel
    inertia = float(model.dof_M0[1])
    slopes = Polynomial(travel.polynomials[0]).deriv()(np.array(travel.positions[0]))
    masses = 0.5 * inertia / slopes**2  # the half of one finger, from (ds/dt)^2 m = I (dq/dt)^2
    assert masses[len(masses) // 2] > 10.0 * masses.min()
    assert masses.min() < travel.mass < 5.0 * masses.min()
