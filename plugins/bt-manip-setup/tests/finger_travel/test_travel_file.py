"""The measured travel is written into the description's file, or into one beside it."""

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from bt_manip.grippers import TwoFingerGripper, two_finger_gripper
from bt_manip.robots import Robot, RobotError, panda, read_description
from bt_manip_setup.finger_travel import TRAVEL_NOTE, measured, write_travel

from .mechanisms import model_of

DESCRIPTION = """# A rig.
model = "rig.xml"
arm_joints = ["turn"]
home = [0.0]
velocity = 1.0
acceleration = 5.0
jerk = 100.0

[gripper]
joints = ["left_joint"]       # the other one follows
fingers = ["left", "right"]
max_speed = 0.2
max_force = 12.0

[tool]  # between the pads
frame = "palm"
position = [0.0, 0.0, 0.11]
"""


@pytest.fixture
def file(tmp_path) -> Path:
    """Give a description without a travel."""
    (tmp_path / "rig.xml").write_text(model_of("hinges"))
    path = tmp_path / "rig.toml"
    path.write_text(DESCRIPTION)
    return path


def test_a_measured_description_makes_a_robot_and_has_the_same_bits_when_read(file):
    described = measured(read_description(file))
    first = Robot(described, gripper=TwoFingerGripper).gripper.mechanism.travel
    path, travel = write_travel(read_description(file))
    assert path == file and travel == described.gripper.parameters["travel"]
    assert Robot(read_description(file), gripper=TwoFingerGripper).gripper.mechanism.travel == first
    assert len(first.widths) == 17 and first.joints == ("left_joint", "right_joint")


def test_the_lines_of_a_description_are_kept_and_an_older_travel_is_replaced(file):
    write_travel(read_description(file))
    once = file.read_text()
    assert once.startswith(DESCRIPTION) and once.count(TRAVEL_NOTE) == 1
    write_travel(read_description(file))
    assert file.read_text() == once
    old = once.removeprefix(DESCRIPTION).replace("0.", "1.")
    start, end = DESCRIPTION.split("[tool]")
    file.write_text(f"{start}{old}\n# The tool.\n[tool]{end}")  # in the middle
    write_travel(read_description(file))
    text = file.read_text()
    assert text.count("[gripper.travel]") == text.count("[gripper.travel.digests]") == 1
    assert text.startswith(start.rstrip()) and end in text
    Robot(read_description(file), gripper=TwoFingerGripper)


def test_what_cannot_be_written_is_said(file):
    file.write_text(
        DESCRIPTION.partition("[gripper]")[0]
        + 'gripper = { joints = ["left_joint"], fingers = ["left", "right"], max_speed = 0.2, '
        "max_force = 12.0 }\n[tool]\nframe = 'palm'\nposition = [0.0, 0.0, 0.11]\n"
    )
    before = file.read_text()
    with pytest.raises(RobotError, match=r"cannot write key 'gripper.travel': give \[gripper\]"):
        write_travel(read_description(file))
    assert file.read_text() == before


def test_a_description_in_python_names_the_file_to_write(file, tmp_path):
    described = replace(read_description(file), source="")
    given = {**described.gripper.parameters, "max_force": 12.0}
    with pytest.raises(RobotError, match="described in Python: give its gripper the path"):
        write_travel(replace(described, gripper=two_finger_gripper(**given)))
    path = tmp_path / "travel.toml"
    described = replace(described, gripper=two_finger_gripper(**given, travel=str(path)))
    assert write_travel(described)[0] == path
    assert "joints" in tomllib.loads(path.read_text())
    Robot(described, gripper=TwoFingerGripper)


def test_the_command_writes_and_says_what_it_measured(bt_manip, file):
    code, out, _ = bt_manip("robot", "measure", file)
    assert (code, out) == (0, f"wrote {file}: the fingers open from 0 to 83.02 mm\n")


def test_the_values_of_the_panda_are_up_to_date():
    assert panda().gripper.parameters["travel"].endswith("finger_travel.toml")
    stored = tomllib.loads(Path(panda().gripper.parameters["travel"]).read_text())
    assert measured(panda()).gripper.parameters["travel"] == stored
