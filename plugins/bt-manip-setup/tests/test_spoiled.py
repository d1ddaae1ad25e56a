"""Descriptions spoiled in one line: what `robot check` does not find does not fail a run."""

import json

import pytest

from bt_manip.models import bundled_path
from bt_manip_setup import check_description, describe_robot, description_text
from tests.support.program import run_program

CYCLES = 20
LINES = {
    "weak grip": ("max_force = 120.0", "max_force = 0.5"),
    "too strong": ("max_force = 120.0", "max_force = 900.0"),
    "opens less": ("open_width = 0.08", "open_width = 0.02"),
    "slow fingers": ("max_speed = 0.1", "max_speed = 0.005"),
    "soft pads": ("solref = [0.004, 1.0]", "solref = [0.2, 1.0]"),
    "tool too high": ("position = [0.0, 0.0, 0.1036]", "position = [0.0, 0.0, 0.09]"),
    "tool aside": ("position = [0.0, 0.0, 0.1036]", "position = [0.0, 0.015, 0.1036]"),
    "far away": ("position = [0.05, 0.0, 0.1]", "position = [-0.6, 0.0, 0.1]"),
    "too fast": ("acceleration = [5.0, 5.0", "acceleration = [60.0, 60.0"),
    "heavy rotors": ("jerk = [", "armature = 5.0\njerk = ["),
}  # fmt: skip


@pytest.fixture(scope="module")
def good(parts, tmp_path_factory):
    path = tmp_path_factory.mktemp("good") / "arm.toml"
    draft = describe_robot(str(bundled_path("panda/panda.xml")), parts, name="arm")
    return description_text(draft.description, draft.notes, path, "an arm")


@pytest.mark.soak
@pytest.mark.parametrize("spoiled", LINES)
def test_a_description_without_findings_picks(good, parts, tmp_path_factory, spoiled):
    before, after = LINES[spoiled]
    assert before in good
    path = tmp_path_factory.mktemp("good") / "arm.toml"
    path.write_text(good.replace(before, after, 1))
    findings = check_description(path, parts, CYCLES).findings
    print(spoiled, findings)
    if findings:
        return
    report = path.with_suffix(".json")
    command = ["run", "pick_place", "--robot", path, "--cycles", CYCLES, "--quiet"]
    run_program(*command, "--seed", 7, "--report", report)
    cycles = json.loads(report.read_text())["cycles"]
    assert len(cycles) == CYCLES
    assert sum(cycle["status"] != "SUCCESS" for cycle in cycles) <= 1
