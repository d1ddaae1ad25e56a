"""A hand is found in its model: its parts, and postures in which the thumb meets the fingers."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest
from dm_control import mjcf

from bt_manip_hands.hand import Hand
from bt_manip_hands.hand_search import find_hand

ARM = (
    '<mujoco><worldbody><body name="arm"><joint name="turn"/><geom size="0.01"/></body>'
    "</worldbody></mujoco>"
)
FINGERS = ("ff_base", "mf_base", "rf_base")


def carried(path):
    root = mjcf.from_xml_string(ARM)
    root.find("body", "arm").add("site", name="end").attach(mjcf.from_path(str(path)))
    return mujoco.MjModel.from_xml_string(root.to_xml_string(), root.get_assets())


@pytest.mark.parametrize("side", ["right", pytest.param("left", marks=pytest.mark.soak)])
def test_palm_thumb_and_postures_of_a_hand_are_found(hand_models, side):
    model = carried(hand_models / "wonik_allegro" / f"{side}_hand.xml")
    found, prefix = find_hand(model, ["turn"]), f"allegro_{side}/"
    given = found.parameters
    assert (given["palm"], given["thumb"]) == (f"{prefix}palm", f"{prefix}th_base")
    assert set(given["fingers"]) == {prefix + name for name in FINGERS}
    assert found.max_force > 3.0 and given["max_width"] >= 0.06
    data = mujoco.MjData(model)
    addresses = [int(model.joint(name).qposadr[0]) for name in given["joints"]]
    tips = ("ff_tip", "mf_tip", "rf_tip", "th_tip")
    geoms = [int(model.body(prefix + name).geomadr[0]) + 1 for name in tips]
    gaps = {}
    for posture in ("open", "closed"):
        data.qpos[addresses] = given[posture]
        mujoco.mj_kinematics(model, data)
        T = data.body(f"{prefix}palm")
        centres = (data.geom_xpos[geoms] - T.xpos) @ T.xmat.reshape(3, 3)
        local = (centres - found.T_bt.translation) @ found.T_bt.rotation
        fingers, thumb = local[:3].mean(axis=0), local[3]
        gaps[posture] = fingers[1] - thumb[1]  # y points from the thumb to the fingers
        assert abs(fingers[2]) < 0.02 and abs(thumb[2]) < 0.02
    assert gaps["open"] > given["max_width"] > 2.0 * gaps["closed"]
    # The closed thumb presses with 80 % of what its weakest joint can: the force whose work over
    # the way of the tip along the closing is that of the joint's torque.
    thumb, closing, forces = addresses[-4:], T.xmat.reshape(3, 3) @ found.T_bt.rotation[:, 1], []
    for address, effort in zip(thumb, given["effort"][-4:], strict=True):
        ways = []
        for turn in (-1e-5, 1e-5):  # [rad]
            data.qpos[addresses] = given["closed"]
            data.qpos[address] += turn
            mujoco.mj_kinematics(model, data)
            ways.append(float(data.geom_xpos[geoms[-1]] @ closing))
        lever = abs(ways[1] - ways[0]) / 2e-5  # [m]
        forces.append(effort / lever if lever > 5e-3 else np.inf)
    assert found.max_force == pytest.approx(0.8 * min(forces), rel=0.03)


def test_two_fingers_are_no_hand(hand_models):
    model = mujoco.MjModel.from_xml_path(str(hand_models / "universal_robots_ur5e" / "ur5e.xml"))
    assert find_hand(model, [model.joint(j).name for j in range(model.njnt)]) is None
    assert Hand.found_in(model, ["shoulder_pan_joint"]) is None


@pytest.mark.soak
def test_an_arm_with_a_hand_that_nobody_described_picks(hand_models, tmp_path):
    arm = hand_models / "universal_robots_ur5e" / "ur5e.xml"
    hand = hand_models / "wonik_allegro" / "left_hand.xml"
    command = [sys.executable, "-m", "bt_manip", "robot", "new", arm, "--gripper", hand]
    done = subprocess.run([*command, "-o", tmp_path / "one.toml"], capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    assert (
        "20 of 20 cycles" in done.stderr and 'kind = "hand"' in (tmp_path / "one.toml").read_text()
    )
