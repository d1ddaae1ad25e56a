"""Fingers are found in a compiled model, whatever moves them."""

from dataclasses import replace
from itertools import product

import mujoco
import numpy as np
import pinocchio as pin
import pytest
from numpy.polynomial import Polynomial
from numpy.polynomial.polynomial import polyval

from bt_manip.robots import RobotError
from bt_manip_setup.finger_travel import OverlappingHullsError, find_fingers, search

from .mechanisms import ARM, MECHANISMS, Kind, fingers_in, model_of, rig


def check_widths(kind, found):
    """Check the openings against the distance of the pads in MuJoCo, and the travel of fingers."""
    model, travel = mujoco.MjModel.from_xml_string(model_of(kind)), found.travel
    data = mujoco.MjData(model)
    pads = [int(model.body(name).geomadr[0]) for name in found.fingers]
    for row, width in enumerate(travel.widths):
        for name, positions in zip(travel.joints, travel.positions, strict=True):
            data.joint(name).qpos = positions[row]
        mujoco.mj_kinematics(model, data)
        if "slide" in kind and "hinge" not in kind:  # else pads do not stay parallel
            assert mujoco.mj_geomDistance(model, data, *pads, 1.0, None) == pytest.approx(width)
        q = [float(data.joint(found.joints[i]).qpos[0]) for i in (0, -1)]
        assert sum(map(polyval, q, travel.polynomials)) == pytest.approx(width, abs=2e-4)


@pytest.mark.parametrize("kind", MECHANISMS)
def test_fingers_of_every_kind_are_found(kind):
    mechanism = MECHANISMS[kind]
    found = fingers_in(model_of(kind))
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
    assert found.travel.centre[1] == 0.5 * mechanism.one_moves  # the middle of the pads moves
    check_widths(kind, found)
    if mechanism.force is None:
        assert found.max_force is None
    else:
        assert found.max_force == pytest.approx(mechanism.force, rel=0.05)


def test_the_first_joint_moves_the_first_finger_also_where_a_gear_of_the_second_comes_before():
    gear = (
        '<body name="gear"><joint name="gear"/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
    )
    tie = '<equality><joint joint1="gear" joint2="right_joint"/></equality><actuator>'
    xml = model_of("slides").replace('<body name="left"', f'{gear}</body><body name="left"')
    found = fingers_in(xml.replace("<actuator>", tie))
    assert found.joints == ("left_joint", "right_joint") and found.fingers == ("left", "right")


def test_the_measured_openings_do_not_depend_on_the_pose_of_the_arm():
    turned = model_of("coupled_slides").replace('pos="0 0 1"', 'pos="0 0 1" euler="30 20 10"')
    found, other = (fingers_in(xml) for xml in (model_of("coupled_slides"), turned))
    assert np.allclose(found.T_bt.homogeneous, other.T_bt.homogeneous, atol=1.1e-3)
    assert found.travel.open_width == pytest.approx(other.travel.open_width, abs=1e-6)


def test_the_loss_of_a_finger_is_the_power_that_its_joints_dissipate():
    rest = 'armature="0.002" damping="0.3" frictionloss="0.7"'
    xml = model_of("hinges").replace('armature="0.002"', rest)
    xml = xml.replace(rest, 'armature="0.003" damping="0.2" frictionloss="0.4"', 1)
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
    power = float(model.dof_frictionloss @ np.abs(data.qvel))
    assert 2.0 * travel.friction * speed == pytest.approx(power, rel=0.02)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    assert travel.mass * speed**2 == pytest.approx(0.5 * data.qvel @ M @ data.qvel, rel=0.02)


def test_the_effort_against_springs_is_that_of_each_motor():
    """Each finger has a spring of its own, at rest 10 mm beyond the closed one."""
    for kind, scale in (("slides", 1.0), ("coupled_slides", 2.0)):
        springs = 'armature="0.05" stiffness="50" springref="-0.01"'
        xml = model_of(kind).replace('armature="0.05"', springs)
        if scale == 2.0:  # the second spring pulls the other way
            xml = 'springref="0.01"'.join(xml.rsplit('springref="-0.01"', 1))
        travel = fingers_in(xml).travel
        for q in (0.02, 0.035):
            assert polyval(q, travel.holding[0]) == pytest.approx(scale * 50 * (q + 0.01), rel=0.03)


LOOSE = '<body><joint name="{}"/><geom size="0.01"/></body>'
JAW = """<body name="jaw" pos="0 0 0.1"><joint name="a" range="0 1" limited="true"/>
  <geom size="0.01" {}/></body>"""


@pytest.mark.parametrize(
    ("palm", "message"),
    [
        ("", "no joints beyond the arm's last one, 'turn'"),
        ("".join(map(LOOSE.format, "abc")), "3 joints beyond 'turn' move independently: 'a', 'b',"),
        (LOOSE.format("a"), "without a range: 'a'"),
        (JAW.format(""), "no two surfaces .* open and close by more than 2 mm$"),
        (
            JAW.format('contype="0" conaffinity="0"'),
            "by more than 2 mm; give a collision geometry to the bodies without one: 'jaw'$",
        ),
    ],
)
def test_what_is_no_gripper_of_two_fingers_is_said(palm, message):
    with pytest.raises(RobotError, match=message):
        fingers_in(rig(Kind(palm)))


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
        fingers_in(meshes)
    with pytest.raises(RobotError, match="they open to -2 mm there"):
        fingers_in(boxes)


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
    coupled = '<equality><joint joint1="a" joint2="b"/></equality>'
    motor = '<motor joint="a" ctrlrange="-20 20"/>'
    found = fingers_in(rig(Kind(palm, coupled, motor)))
    assert set(found.fingers) == {"left_pad", "right_pad"}


def test_a_given_tool_frame_is_measured_and_turned_and_has_to_be_between_the_fingers():
    xml, at = model_of("coupled_slides"), np.array([0.0, 0.0, 0.115])
    turned = pin.SE3(pin.rpy.rpyToMatrix(0.0, np.pi / 2, 0.0), at)
    for T, rotation in ((pin.SE3(np.eye(3), at), np.eye(3)), (turned, None)):
        found = fingers_in(xml, tool=("palm", T))
        assert found.T_bt.translation == pytest.approx(at)
        assert found.T_bt.rotation[:, 2] == pytest.approx((0, 0, 1))
        assert rotation is None or np.allclose(found.T_bt.rotation, rotation)
    with pytest.raises(RobotError, match=r"moves with 'left'; .*, 'palm'"):
        fingers_in(xml, tool=("left", pin.SE3.Identity()))
    beyond = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.2]))
    with pytest.raises(RobotError, match="not between the fingers"):
        fingers_in(xml, tool=("palm", beyond))


def test_a_hand_that_tendons_pull_is_not_taken_for_two_fingers():
    nail = '<site name="base"/><body><geom size="0.01"/><site name="tip" pos="0 0 0.1"/></body>'
    tendon = '<spatial name="{}"><site site="base"/><site site="tip"/></spatial>'
    tendons = "".join(map(tendon.format, "abc"))
    motors = "".join(map('<motor tendon="{}"/>'.format, "abc"))
    palm = nail + MECHANISMS["slides"].palm
    with pytest.raises(RobotError, match="3 actuators pull on tendons beyond 'turn'"):
        fingers_in(rig(Kind(palm, f"<tendon>{tendons}</tendon>", motors)))


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
    travel = find_fingers(model, ARM).travel
    inertia = float(model.dof_M0[1])
    slopes = Polynomial(travel.polynomials[0]).deriv()(np.array(travel.positions[0]))
    masses = 0.5 * inertia / slopes**2  # the half of one finger, from (ds/dt)^2 m = I (dq/dt)^2
    assert masses[len(masses) // 2] > 10.0 * masses.min()
    assert masses.min() < travel.mass < 5.0 * masses.min()


@pytest.mark.parametrize("tilt, turn", [(0.0, 0.3), (0.0, 0.5), (0.0, -0.5), (0.25, 0.5)])
def test_fingers_beside_the_palm_that_are_turned_by_more_than_20_degrees_turn_the_tool(tilt, turn):
    """Its z axis is the palm's, or perpendicular to the closing direction beside that."""
    place = f'pos="0.013 -0.02 0.04" euler="{tilt} 0 {turn}"'
    xml = model_of("slides").replace('pos="0 0.0 0.03"', place)
    found = fingers_in(xml)
    R_bf = pin.utils.rotate("x", tilt) @ pin.utils.rotate("z", turn)
    x, y, z = np.eye(3)
    if abs(turn) > 0.35:
        y = R_bf[:, 1]
        x = np.cross(y, z) / np.linalg.norm(np.cross(y, z))
    R = np.column_stack([x, y, np.cross(x, y)])
    assert found.T_bt.rotation == pytest.approx(R, abs=1e-6)
    assert found.T_bt.translation == pytest.approx(
        R_bf[:, 2] * 0.08 + (0.013, -0.02, 0.04), abs=2e-3
    )
    assert found.travel.open_width == pytest.approx(0.08)
    assert found.travel.closing == pytest.approx(R.T @ R_bf[:, 1], abs=1e-6)


@pytest.mark.parametrize(("begin", "offset"), [(0.01, -0.01), (4e-4, -4e-4), (2e-4, 0.0)])
def test_slides_keep_the_offset_of_their_positions_from_0_3_mm_on(begin, offset):
    xml = model_of("slides").replace('range="0.0 0.04"', f'range="{begin} {0.04 + begin}"')
    xml = xml.replace('pos="0 0.0 0.03"', f'pos="0 {-begin} 0.03"', 1)
    xml = xml.replace('pos="0 0.0 0.03"', f'pos="0 {begin} 0.03"')
    travel = fingers_in(xml).travel
    assert travel.polynomials == pytest.approx(np.array([[offset, 1.0]] * 2), abs=1e-6)
    assert travel.open_width == pytest.approx(0.08, abs=5e-4)


def test_the_tool_is_15_mm_from_the_ends_of_long_pads():
    xml = model_of("slides").replace('size="0.01 0.004 0.01"', 'size="0.01 0.004 0.03"')
    found = fingers_in(xml)
    assert found.T_bt.translation[2] == pytest.approx(0.14 - 0.015, abs=1.1e-3)


@pytest.mark.parametrize("limits", ['range="-1 1"', ""])
def test_joints_that_move_no_surface_to_another_one_or_have_no_range_are_left_aside(limits):
    """Beside the fingers is a lever whose end moves by some millimetres."""
    lever = f'<joint name="lever" axis="1 2 3" {limits}/><geom size="0.01" pos="0 0 0.01"/>'
    xml = model_of("offset_slides").replace("<!--palm-->", f'<body pos="0.1 0 0">{lever}</body>')
    found = fingers_in(xml)
    assert found.joints == ("left_joint", "right_joint")


@pytest.mark.parametrize("kind", ["slides", "coupled_slides", "hinges"])
@pytest.mark.parametrize("beside", [0.8e-3, 1.2e-3, -1.2e-3])  # [m]
def test_pads_that_meet_more_than_1_mm_beside_a_given_tool_have_their_centre_there(kind, beside):
    """The tool is given in the frame of a camera at the palm."""
    camera = '<body name="camera" pos="0.05 0.02 0.03" euler="0.3 -0.4 1.2"><geom size="0.01"/>'
    xml = model_of(kind).replace("<!--palm-->", f"{camera}</body>")
    model = mujoco.MjModel.from_xml_string(xml)
    T = pin.SE3(pin.Quaternion(*model.body("camera").quat), model.body("camera").pos)
    tool = pin.SE3(np.eye(3), np.array([0.0, beside, 0.11]))
    found = fingers_in(xml, tool=("camera", T.inverse() * tool))
    assert found.T_bt.isApprox(tool, 1e-9)
    centre = (0.0 if abs(beside) < 1e-3 else -beside, 0.0)
    assert found.travel.centre == pytest.approx(centre, abs=2e-5)
    check_widths(kind, found)
