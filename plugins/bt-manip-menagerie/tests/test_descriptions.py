"""The files, and robots that are described by nothing but such a file."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from bt_manip.plugins import load_plugins
from bt_manip.robots import read_description
from bt_manip_menagerie import description_files

UR5E_WITH_XARM_GRIPPER = Path(__file__).with_name("ur5e_xarm.toml")


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


def test_an_arm_and_a_gripper_that_no_robot_combines_pick_and_place(run):
    code, report = run(UR5E_WITH_XARM_GRIPPER, 2)
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
