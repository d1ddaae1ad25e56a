"""An arm and a gripper from a file each, put together as a third file says."""

import dataclasses
from math import asin, cos, sin
from pathlib import Path

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, RobotError, read_description
from bt_manip_contracts import verify
from bt_manip_setup.finger_travel import measured
from tests.robot_fixtures import compiled

FILE = Path(__file__).parent / "models" / "post.toml"
CRANK, ROOT = 0.05, 0.02  # [m] of tests/robots/models/pincers.xml


@pytest.fixture(scope="module")
def description():
    return read_description(FILE)


@pytest.fixture(scope="module")
def robot(description):
    return compiled(description, gripper=TwoFingerGripper)


def changed(description, **changes):
    gripper = description.gripper
    own = {key: changes.pop(key) for key in list(changes) if hasattr(gripper, key)}
    parameters = {**gripper.parameters, **changes}
    parameters = {key: value for key, value in parameters.items() if value is not None}
    gripper = dataclasses.replace(gripper, parameters=parameters, **own)
    return dataclasses.replace(description, gripper=gripper)


def test_tool_and_pedestal_are_where_base_mount_and_tool_put_them(robot):
    # Column 0.5 + base 0.2 up, turned by half a turn: the boom's end is at x = -0.4. The mount
    # points down; the gripper is 10 mm under it and the tool 110 mm under that.
    T = robot.tool_pose
    assert np.allclose(T.translation, (-0.4, 0.0, 0.7 - 0.12), atol=1e-9)
    assert np.allclose(T.rotation[:, 2], (0, 0, -1), atol=1e-9)
    geom = robot.mj_model.geom("pedestal")  # it stands under the base
    assert np.allclose(geom.size, (0.05, 0.05, 0.1)) and np.allclose(geom.pos, (0.0, 0.0, 0.1))


def test_bodies_of_both_models_and_the_pedestal_may_be_excluded(description):
    pairs = (("column", "left_finger"), ("boom", "pincers/left_finger"), ("pedestal", "boom"))
    excluding = compiled(dataclasses.replace(description, exclude=pairs), gripper=TwoFingerGripper)
    model = excluding.mj_model
    column, boom, pedestal, finger = (
        model.body(name).id for name in ("column", "boom", "pedestal", "pincers/left_finger")
    )
    ids = ((column, finger), (boom, finger), (pedestal, boom))
    signatures = {(min(pair) << 16) + max(pair) for pair in ids}
    assert set(model.exclude_signature.tolist()) == signatures


def test_the_way_and_inertia_of_a_finger_are_those_of_its_crank(robot):
    travel = robot.gripper.mechanism.travel
    for polynomial in travel.polynomials:
        for q in np.linspace(-0.4, 0.6, 11):
            s = np.polynomial.polynomial.polyval(q, polynomial)
            assert s == pytest.approx(ROOT + CRANK * sin(q), abs=2e-5)
    assert travel.open_width == pytest.approx(0.1, abs=1e-4)
    assert travel.min_width == pytest.approx(0.0, abs=1e-4)
    assert travel.ratios == pytest.approx([1.0, 1.0], abs=1e-3)
    # A crank of 30 g with its rotor, a finger of 20 g that only shifts, a rotor at its wrist.
    q = asin((0.5 * travel.widths[8] - ROOT) / CRANK)
    crank = 0.03 * CRANK**2 / 3 + 0.002
    finger = 0.02 * CRANK**2
    per_angle = crank + finger + 0.0002
    assert travel.mass == pytest.approx(per_angle / (CRANK * cos(q)) ** 2, rel=0.03)
    assert travel.loss == pytest.approx((0.02 + 0.0005) / (CRANK * cos(q)) ** 2, rel=0.01)


def test_the_motor_is_strong_enough_for_the_described_force(robot):
    (motor,) = robot.gripper.mechanism.actuators
    assert motor.tendon.name == "both"
    # Power: F dL = 2 f ds with dL = dq, and a fifth for friction; steepest where cos(q) is 1.
    assert motor.forcerange[1] == pytest.approx(1.2 * 2 * 40.0 * CRANK, rel=0.02)


def test_it_starts_open_with_all_joints_of_the_mechanism_in_place(robot):
    data, model = robot.mj_data, robot.mj_model
    robot.initialize_episode(None, None)
    mujoco.mj_forward(model, data)
    equality = data.efc_type[: data.nefc] == int(mujoco.mjtConstraint.mjCNSTR_EQUALITY)
    assert np.abs(data.efc_pos[: data.nefc][equality]).max() < 1e-3
    left, right = robot.gripper.mechanism.geoms
    gap = mujoco.mj_geomDistance(model, data, left[0], right[0], 1.0, None)
    assert gap == pytest.approx(0.1, abs=3e-4)


def test_the_model_is_the_one_that_is_simulated_with_pads_friction_and_motors_as_described(
    robot, rng
):
    model, travel = robot.mj_model, robot.gripper.mechanism.travel
    planned = robot.make_model()
    assert verify(model, planned.model, rng=rng, qpos=planned.locked_qpos).worst < 1e-9
    assert model.nu == 3 and model.nlight == 0  # the servos and worlds of both files are left out
    assert (model.actuator_biasprm == 0).all()
    assert model.opt.gravity[2] == pytest.approx(-9.81)
    for geoms in robot.gripper.mechanism.geoms:
        assert (model.geom_friction[geoms[0]] == 0.0).all()  # the object's counts
        assert model.geom_solref[geoms[0]] == pytest.approx([0.004, 1.0])
        assert model.geom_priority[geoms[0]] == 0 and model.geom_solmix[geoms[0]] == 1e6
    moving = model.jnt_dofadr[[model.joint(f"pincers/{name}").id for name in travel.joints]]
    assert (model.dof_frictionloss[moving] == 0.001).all()
    assert (model.dof_frictionloss[robot.dof_adr] == 0.0).all()


def test_a_body_can_be_the_mount_and_a_site_the_tool(description):
    turned = changed(description, mount="boom", T_mg=pin.SE3(np.eye(3), np.array([0.1, 0, 0])))
    turned = dataclasses.replace(
        turned, tool_frame="end", T_ft=pin.SE3.Identity(), T_rb=pin.SE3.Identity()
    )
    robot = compiled(turned)
    assert np.allclose(robot.tool_pose.translation, (0.4, 0.0, 0.5), atol=1e-9)
    palm = robot.mj_data.body("pincers/palm").xpos
    assert np.allclose(palm, (0.4, 0.0, 0.5), atol=1e-9)


def pincers(tmp_path, old, new):
    """Write the gripper's model with something replaced; give its path."""
    model = (FILE.parent / "pincers.xml").read_text()
    assert old in model
    (tmp_path / "pincers.xml").write_text(model.replace(old, new))
    return str(tmp_path / "pincers.xml")


COUPLING = '<joint joint1="left_driver" joint2="right_driver" solref="0.004 1"/>'


def test_two_motors_may_move_two_linkages(description, tmp_path):
    model = pincers(tmp_path, COUPLING, "")
    apart = measured(changed(description, model=model, motor=None))
    robot = Robot(apart, gripper=TwoFingerGripper)
    assert len(robot.gripper.mechanism.actuators) == 2
    assert robot.gripper.mechanism.actuators[0].forcerange[1] == pytest.approx(
        1.2 * 40.0 * CRANK, rel=0.02
    )


DRIVER = '<joint name="left_driver" class="driver"/>\n        <geom class="crank"/>'
SPARE = '<body name="spare"><joint name="spare" class="driver"/><geom class="crank"/></body>'


@pytest.mark.parametrize(
    ("edit", "changes", "message"),
    [
        ((), {"mount": "ent"}, "there is no 'ent'; did you mean 'end'"),
        ((), {"joints": ["left_drive", "right_driver"]}, "no joint 'left_drive'; did you mean 'le"),
        ((), {"fingers": ["left_finger", "left"]}, "no body 'left'"),
        ((), {"motor": "bot"}, "no joint 'bot'"),
        ((), {"open_width": 0.11}, "open_width is 110.0 mm, but .* open to 100.0 mm"),
        ((), {"model": "nowhere.xml"}, "no model file nowhere.xml"),
        ((), {"fingers": ["left_crank", "right_crank"]}, "left_crank' has no geom that collides"),
        (
            (DRIVER, DRIVER + SPARE),
            {"joints": ["spare"], "motor": "spare"},
            "'pincers/spare' does not open and close",
        ),
        ((COUPLING, ""), {}, "nothing in the model couples joint .*right_driver"),
    ],
)
def test_what_does_not_fit_is_said(description, tmp_path, edit, changes, message):
    if edit:
        changes = {"model": pincers(tmp_path, *edit), **changes}
    with pytest.raises(RobotError, match=message):
        Robot(measured(changed(description, **changes)), gripper=TwoFingerGripper)


def test_the_motor_of_coupled_fingers_is_found(description, robot):
    without = measured(changed(description, motor=None))
    found = Robot(without, gripper=TwoFingerGripper).gripper.mechanism
    (motor,), (described,) = found.actuators, robot.gripper.mechanism.actuators
    assert motor.tendon.name == "both"
    assert motor.forcerange == pytest.approx(described.forcerange)  # read, and measured here
