"""The files, and robots that are described by nothing but such a file."""

import json
from pathlib import Path

import pytest

from bt_manip.plugins import load_plugins
from bt_manip.robots import read_description
from bt_manip_menagerie import description_files
from tests.support.program import run_program

UR5E_WITH_XARM_GRIPPER = Path(__file__).with_name("ur5e_xarm.toml")


@pytest.fixture
def run(tmp_path):
    """Run pick_place and give its exit code and its report."""

    def go(robot, cycles):
        report = tmp_path / "report.json"
        options = ["--robot", robot, "--cycles", cycles, "--report", report]
        code = run_program("run", "pick_place", "--quiet", *options)
        return code, json.loads(report.read_text())

    return go


def test_each_file_is_a_registered_robot_and_is_read_without_models(monkeypatch, tmp_path):
    monkeypatch.setenv("MENAGERIE_ROOT", str(tmp_path))
    robots = load_plugins().parts.robots
    for path in description_files():
        assert read_description(path) == robots.get(path.stem)
        assert robots.owner(path.stem) == "menagerie"
    assert {"fr3", "iiwa14", "menagerie_panda", "ur5e", "xarm7"} <= set(robots)


def test_an_arm_and_a_gripper_that_no_robot_combines_pick_and_place(run):
    code, report = run(UR5E_WITH_XARM_GRIPPER, 1)
    assert code == 0
    assert [cycle["placed"] for cycle in report["cycles"]] == [True]


@pytest.mark.soak
@pytest.mark.parametrize("path", description_files(), ids=lambda path: path.stem)
def test_twenty_of_twenty_are_placed(path, run):
    code, report = run(path.stem, 20)
    assert code == 0
    assert sum(cycle["placed"] for cycle in report["cycles"]) == 20
    assert sum(cycle["saturated_steps"] for cycle in report["cycles"]) == 0
    assert not [c for cycle in report["cycles"] for c in cycle["unexpected_contacts"]]
