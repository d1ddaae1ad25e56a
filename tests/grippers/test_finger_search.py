"""Fingers are found in a compiled model, whatever moves them."""

import mujoco
import numpy as np
import pytest

from bt_manip.grippers import find_fingers
from bt_manip.robots import RobotError
from tests.grippers.mechanisms import ARM, MECHANISMS, model_of

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


def test_the_hand_of_the_panda_is_found(compiled_robot):
    found = find_fingers(compiled_robot.alone, PANDA)
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
            "no two surfaces .* open and close by more than 2 mm",
        ),
    ],
)
def test_what_is_no_gripper_of_two_fingers_is_said(old, new, message):
    model = mujoco.MjModel.from_xml_string(model_of("none").replace(old, new))
    with pytest.raises(RobotError, match=message):
        find_fingers(model, ARM)
