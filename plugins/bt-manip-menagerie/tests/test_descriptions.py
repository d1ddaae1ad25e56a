"""The files, and robots that are described by nothing but such a file."""

import json
import subprocess
import sys

import pytest

from bt_manip.plugins import load_plugins
from bt_manip.robots import read_description
from bt_manip_menagerie import description_files

UR5E_WITH_XARM_GRIPPER = """
model = "menagerie:universal_robots_ur5e/ur5e"
arm_joints = [
    "shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint",
    "wrist_1_joint", "wrist_2_joint", "wrist_3_joint",
]
home = [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
velocity = 3.1416
acceleration = 5.0
jerk = 250.0

[base]
position = [0.05, 0.0, 0.1]
quat_wxyz = [0.0, 0.0, 0.0, 1.0]

[tool]
frame = "xarm_gripper_base_link"
position = [0.0, 0.0, 0.153]

[gripper]
model = "menagerie:ufactory_xarm7/hand"
mount = "attachment_site"
joints = ["right_driver_joint", "left_driver_joint"]
fingers = ["right_finger", "left_finger"]
motor = "split"
open_width = 0.085
max_speed = 0.1
max_force = 50.0
armature = 0.005
frictionloss = 0.0

[gripper.pads]
solref = [0.004, 1.0]
"""


@pytest.fixture
def run(tmp_path):
    """Run pick_place from the command line and give its exit code and its report."""

    def go(robot, cycles):
        report = tmp_path / "report.json"
        command = [sys.executable, "-m", "bt_manip", "run", "pick_place", "--quiet"]
        options = ["--robot", str(robot), "--cycles", str(cycles), "--report", str(report)]
        ended = subprocess.run([*command, *options], check=False)
        return ended.returncode, json.loads(report.read_text())

    return go


def test_each_file_is_a_registered_robot():
    robots = load_plugins().parts.robots
    for path in description_files():
        assert read_description(path) == robots.get(path.stem)
        assert robots.owner(path.stem) == "menagerie"
    assert {"fr3", "iiwa14", "menagerie_panda", "ur5e", "xarm7"} <= set(robots)


def test_reading_them_needs_no_models(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    assert len([read_description(path) for path in description_files()]) == 5


def test_an_arm_and_a_gripper_that_nobody_listed_pick_and_place(tmp_path, run):
    path = tmp_path / "ur5e_xarm.toml"
    path.write_text(UR5E_WITH_XARM_GRIPPER)
    code, report = run(path, 2)
    assert code == 0
    assert [cycle["placed"] for cycle in report["cycles"]] == [True, True]


@pytest.mark.soak
@pytest.mark.parametrize("path", description_files(), ids=lambda path: path.stem)
def test_twenty_of_twenty_are_placed(path, run):
    code, report = run(path.stem, 20)
    assert code == 0
    assert sum(cycle["placed"] for cycle in report["cycles"]) == 20
    assert sum(cycle["saturated_steps"] for cycle in report["cycles"]) == 0
    assert not [c for cycle in report["cycles"] for c in cycle["unexpected_contacts"]]
