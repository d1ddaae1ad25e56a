"""Findings about descriptions, each with the key and what to change."""

import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.models import bundled_path
from bt_manip.robots import panda
from bt_manip_contracts import ROBOT_CONTRACT
from bt_manip_setup import check, check_description
from bt_manip_setup.inspection import ReachMap, tool_findings
from bt_manip_setup.trial import Checked

PANDA = f"""
model = "{bundled_path("panda/panda.xml")}"
arm_joints = ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6", "joint7"]
home = [0.0, -0.7854, 0.0, -2.3562, 0.0, 1.5708, 0.7854]
velocity = 2.0
acceleration = 5.0
jerk = 500.0
[tool]
frame = "tool"
[gripper]
joints = ["finger_joint1", "finger_joint2"]
fingers = ["left_finger", "right_finger"]
max_speed = 0.1
max_force = 60.0
travel = "{bundled_path("panda/finger_travel.toml")}"
"""


@pytest.fixture
def checked(parts, tmp_path) -> Callable[..., Checked]:
    def checked(*changes: tuple[str, str], cycles: int = 0) -> Checked:
        text = PANDA
        for before, after in changes:
            assert before in text
            text = text.replace(before, after)
        path = tmp_path / "arm.toml"
        path.write_text(text)
        return check_description(path, parts, cycles)

    return checked


def keys(result: Checked) -> list[str]:
    return [finding.split("key '")[1].split("'")[0] for finding in result.findings]


def test_a_good_description_has_no_findings_but_reach_and_payload_and_is_tried(
    checked, monkeypatch
):
    def tried(description, parts, cycles, report):
        assert description.name == "arm"
        return Checked(["a finding"], [f"{cycles} cycles"])

    monkeypatch.setattr(check, "try_robot", tried)
    monkeypatch.setattr(check, "ROBOT_CONTRACT", ())
    result = checked(cycles=3)
    assert result.facts[0].startswith("reach: ") and "#" in result.facts[1]
    assert result.facts[-2].startswith("payload: ")
    assert (result.findings, result.facts[-1]) == (["a finding"], "3 cycles")


def test_wrong_keys_of_all_tables_are_found_at_once(checked):
    result = checked(
        ("velocity = 2.0", "velocity = -1.0"),
        ("jerk", "jrk"),
        ('frame = "tool"', "frame = 3"),
        ("max_speed = 0.1", "max_speed = 0"),
        ('["left_finger", "right_finger"]', '["left_finger"]'),
    )
    assert keys(result) == [
        "tool.frame", "velocity", "jerk", "jrk", "gripper.fingers", "gripper.max_speed",
    ]  # fmt: skip
    assert all("arm.toml" in finding for finding in result.findings)
    assert result.robot is None


def test_unknown_names_are_found_at_once_with_the_nearest_ones(checked):
    result = checked(
        ('"joint7"', '"joint8"'),
        ('frame = "tool"', 'frame = "tol"'),
        ('"finger_joint2"', '"finger_joint3"'),
        (
            "velocity = 2.0",
            'velocity = 2.0\nexclude = [["link0", "lnk2"]]\nconvex_parts = ["left_fingr"]',
        ),
        ("max_force = 60.0", 'max_force = 60.0\nmotor = "split"'),
    )
    assert keys(result) == [
        "arm_joints", "tool.frame", "exclude", "convex_parts", "gripper.joints", "gripper.motor",
    ]  # fmt: skip
    assert "there is no joint 'joint8'; did you mean 'joint" in result.findings[0]


def test_a_mount_that_the_arm_lacks_is_found_with_the_nearest_name(parts, tmp_path):
    folder = shutil.copytree(Path(__file__).parent / "models", tmp_path / "models")
    text = (folder / "post.toml").read_text().replace('mount = "end"', 'mount = "ned"')
    (folder / "post.toml").write_text(text)
    (finding,) = check_description(folder / "post.toml", parts, 0).findings
    assert "key 'gripper.mount': there is no site or body 'ned'; did you mean 'end'?" in finding


def test_all_missing_models_are_found_at_once(parts, tmp_path):
    shutil.copy(Path(__file__).parent / "models" / "post.toml", tmp_path)
    findings = check_description(tmp_path / "post.toml", parts, 0).findings
    assert [Path(finding.split()[-1]).name for finding in findings] == ["post.xml", "pincers.xml"]


AXIS = "its z axis, the direction of approach, is {} degrees from that of the fingers"
BESIDE = "it is {} mm from the middle of the finger pads"
FITTING = 'frame = "hand", position = [0, 0, 0.1036], quat_wxyz = [1, 0, 0, 0] fit the fingers'


@pytest.mark.parametrize(
    ("tilt", "aside", "findings"),
    [
        (0.345, 0.0195, []),
        (-0.355, 0.0, [AXIS.format(20)]),
        (0.0, -0.021, [BESIDE.format(21)]),
        (np.pi, 0.2, [AXIS.format(180), BESIDE.format(200)]),
    ],
)
def test_a_tool_beside_the_fingers_or_pointing_elsewhere_is_found(tilt, aside, findings):
    T_ft = pin.SE3(pin.utils.rotate("x", tilt), np.array([0.0, aside, 0.0]))
    found = list(tool_findings(replace(panda(), T_ft=T_ft)))
    assert found == [f"robot 'panda': key 'tool': {text}; {FITTING}" for text in findings]


@pytest.mark.parametrize(
    ("below", "gripped", "payload", "finding"),
    [
        (0.041, 0.11, 0.11, "key 'tool': the open gripper reaches 41 mm below it, and it grips"),
        (0.039, 0.09, 0.11, "key 'gripper.max_force': the grip holds 0.09 kg at a friction of 1"),
        (0.039, 0.11, 0.09, "key 'effort': the arm holds 0.09 kg at its tool"),
    ],
)
def test_a_grip_or_an_arm_that_holds_less_than_two_cubes_is_found(
    checked, monkeypatch, below, gripped, payload, finding
):
    reached = ReachMap(np.ones((1, 1), dtype=bool), payload, gripped, below)
    monkeypatch.setattr(check, "reach_map", lambda robot, model: reached)
    monkeypatch.setattr(check, "ROBOT_CONTRACT", ())
    findings = checked().findings
    assert len(findings) == 1 and finding in findings[0]


def test_a_travel_that_was_measured_with_another_tool_frame_is_found(checked):
    first, second = checked(
        ('frame = "tool"', 'frame = "tool"\nposition = [0.0, 0.0, -0.04]')
    ).findings
    assert "with other tool frame; 'bt-manip robot measure " in first
    assert "40 mm from the middle of the finger pads" in second


HOME = "-0.7854, 0.0, -2.3562, 0.0, 1.5708"


@pytest.mark.parametrize(
    ("before", "after", "finding"),
    [
        (HOME, "1.7, 0, -3, 0, 0.1", "key 'home': 'link1' is .* mm inside .*; choose another home"),
        ("jerk", "effort = 8.0\njerk", "key 'effort': 'arm' sags by .* at home.*; check it"),
        ("max_force", "open_width = 0.2\nmax_force", "gripper.open_width is 200.0 mm, but the"),
        (
            "[tool]",
            "[base]\nposition = [0.0, 0.0, -0.3]\n[tool]",
            "key 'base': .*'arm/link0' would be .* mm inside 'world'.*; raise its position",
        ),
    ],
)
def test_a_value_that_the_robot_cannot_have_is_found(checked, monkeypatch, before, after, finding):
    rests = [one for one in ROBOT_CONTRACT if one.__name__ == "it_stands_still_at_home"]
    monkeypatch.setattr(check, "ROBOT_CONTRACT", rests)
    assert re.search(finding, "\n".join(checked((before, after)).findings), re.DOTALL)
