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
    # Fingers do not spread, and no joint is within a tenth of its range of a limit.
    lower, upper = model.jnt_range[[model.joint(name).id for name in given["joints"]]].T
    q = np.array([given["open"], given["closed"]])
    spread = [i for i, name in enumerate(given["joints"]) if name[-4:] in ("ffj0", "mfj0", "rfj0")]
    assert q[:, spread] == pytest.approx(0.0, abs=1e-3) and len(spread) == 3
    rest = np.delete((q - lower) / (upper - lower), spread, axis=1)
    assert rest.min() > 0.099 and rest.max() < 0.901
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


def small_hand(palm: str, wrist: str = "") -> mujoco.MjModel:
    """Return a turned hand with two fingers and a thumb of 9 cm, and its palm, if any, there."""
    digits = ""
    for name, x, y, axis in (("f", -0.02, 0.04, "1 0 0"), ("g", 0.02, 0.04, "1 0 0"),
                             ("thumb", 0.0, -0.04, "-1 .2 0")):  # fmt: skip
        digits += f"""<body name="{name}" pos="{x} {y} 0.02">
          <joint name="{name}1" axis="{axis}" range="-0.6 1.2"/>
          <geom type="capsule" size="0.008" fromto="0 0 0.01 0 0 0.04"/>
          <body pos="0 0 0.05"><joint name="{name}2" axis="{axis}" range="-0.3 1.3"/>
            <geom type="capsule" size="0.007" fromto="0 0 0 0 0 0.02"/>
            <geom name="{name}_tip" size="0.01" pos="0 0 0.04"/></body></body>"""
    plate = f'<geom type="box" size="0.03 0.03 0.01" pos="{palm}"/>' if palm else ""
    return mujoco.MjModel.from_xml_string(f"""<mujoco><compiler angle="radian"/><worldbody>
      <body name="arm"><joint name="turn"/><geom size="0.01"/>
        <body name="palm" pos="0.1 0.2 0.3" euler="0.3 0.2 0.1">{wrist}
          {plate}{digits}</body></body></worldbody>
      <actuator><motor joint="f1" ctrlrange="-.4 .4"/><motor joint="thumb2" ctrlrange="-.2 .2"/>
      </actuator></mujoco>""")


def test_a_hand_opens_by_its_width_and_closes_in_front_of_a_palm_that_is_not_beside_it():
    model = small_hand("0 0 0")
    found = find_hand(model, ["turn"])
    given, data = found.parameters, mujoco.MjData(model)
    assert given["joints"] == ["f1", "f2", "g1", "g2", "thumb1", "thumb2"]
    assert given["effort"] == [0.4, 0.5, 0.5, 0.5, 0.5, 0.2]  # 0.5 N m where it is not limited
    assert given["stiffness"] == pytest.approx(np.array(given["effort"]) / np.radians(10), rel=5e-3)
    for posture, distance, off in (
        ("open", given["max_width"] + 0.02, 0.016), ("closed", 0.014, 0.006),
    ):  # fmt: skip
        for name, q in zip(given["joints"], given[posture], strict=True):
            data.joint(name).qpos = q
        mujoco.mj_kinematics(model, data)
        tips = np.array([data.geom(f"{name}_tip").xpos for name in ("f", "g", "thumb")])
        local = (tips - data.body("palm").xpos) @ data.body("palm").xmat.reshape(3, 3)
        local = (local - found.T_bt.translation) @ found.T_bt.rotation
        apart = local[:2].mean(axis=0) - local[2]
        assert np.linalg.norm(apart) == pytest.approx(distance, abs=off)
        # The y axis points from the thumb to the fingers.
        assert posture == "closed" or apart[1] > 0.9 * np.linalg.norm(apart)
    assert found.T_bt.rotation[:, 2] == pytest.approx([0.0, 0.0, 1.0], abs=0.1)
    assert found.T_bt.translation == pytest.approx([0.0, 0.0, 0.1], abs=0.02)
    assert given["max_width"] == 0.075  # 9 cm are too wide for these fingers
    assert find_hand(small_hand(""), ["turn"]).parameters == given  # without geoms of a palm
    for palm in ("0 0.3 0.1", "0 -0.3 0.1"):  # beside it
        assert find_hand(small_hand(palm), ["turn"]) is None


def test_fingers_that_meet_too_near_to_a_palm_and_those_beyond_a_wrist_are_no_hand():
    assert find_hand(small_hand("0 0 0.06"), ["turn"]) is None
    assert find_hand(small_hand("0 0 0", wrist="<joint/>"), ["turn"]) is None


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
