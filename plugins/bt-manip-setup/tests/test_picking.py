"""Arms that nobody described: their models become descriptions, which pick without any edit."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.program import run_program

from .assembled_arms import (
    SIX_JOINTS,
    write_jaw_arm,
    write_linkage_arm,
    write_mimic_arm,
    write_mobile_arm,
)

GRIPPER = "robotiq_2f85/2f85.xml"
ARMS = {  # by the fixture of their folder, with a gripper for arms that have none
    "menagerie": {
        "franka_emika_panda/panda.xml": None,
        "franka_fr3/fr3.xml": GRIPPER,
        "kuka_iiwa_14/iiwa14.xml": GRIPPER,
        "ufactory_xarm7/xarm7.xml": None,
        "universal_robots_ur5e/ur5e.xml": GRIPPER,
    },
    "more_models": {
        "kinova_gen3/gen3.xml": GRIPPER,
        "trossen_vx300s/vx300s.xml": None,
        "trossen_wx250s/wx250s.xml": None,
        "trs_so_arm100/so_arm100.xml": None,
    },
}
ASSEMBLED = {
    "mimic joint": (write_mimic_arm, None),
    "jaw": (write_jaw_arm, None),
    "linkage": (write_linkage_arm, None),
    "suction cup": (lambda folder: SIX_JOINTS, "suction"),
}


def pick(
    folder: Path, model: Path, gripper: Path | str | None, cycles: int
) -> list[dict[str, Any]]:
    """Describe a robot from its model and return the cycles of pick_place with it."""
    file, report = folder / "robot.toml", folder / "report.json"
    carried = [] if gripper is None else ["--gripper", str(gripper)]
    assert run_program("robot", "new", model, *carried, "--cycles", 0, "-o", file) == 0
    command = ["run", "pick_place", "--robot", file, "--cycles", cycles, "--quiet"]
    run_program(*command, "--report", report)
    return list(json.loads(report.read_text())["cycles"])


def check_cycles(cycles: list[dict[str, Any]]) -> None:
    for cycle in cycles:
        assert cycle["status"] == "SUCCESS", cycle["reason"]
        assert not cycle["unexpected_contacts"]


def test_an_arm_with_a_turning_jaw_picks_at_the_first_attempt(tmp_path, more_models, capsys):
    cycles = pick(tmp_path, more_models / "trs_so_arm100" / "so_arm100.xml", None, 1)
    file = tmp_path / "robot.toml"
    out = capsys.readouterr().out
    assert out == f"wrote {file}, not tried; next:\n  bt-manip robot check {file}\n"
    check_cycles(cycles)
    assert {phase["status"] for phase in cycles[0]["phases"]} == {"SUCCESS"}
    assert cycles[0]["max_tracking_error_rad"] < 1e-3 and cycles[0]["limits"]["effort"] < 1.0


@pytest.mark.soak
@pytest.mark.parametrize(("source", "model"), [(s, model) for s in ARMS for model in ARMS[s]])
def test_arms_of_menagerie_pick(tmp_path, request, source, model):
    folder, gripper = request.getfixturevalue(source), ARMS[source][model]
    check_cycles(pick(tmp_path, folder / model, gripper and folder / gripper, 20))


def test_a_chosen_arm_of_a_larger_robot_picks(tmp_path, capsys):
    """Its platform, torso and head are locked."""
    model, file = write_mobile_arm(tmp_path), tmp_path / "arm.toml"
    joints = ",".join(f"joint{i}" for i in range(1, 7))
    assert run_program("robot", "new", model, "--joints", joints, "--cycles", 1, "-o", file) == 0
    assert "pick_place: 1 of 1 cycles" in capsys.readouterr().err


@pytest.mark.soak
@pytest.mark.parametrize("assembled", ASSEMBLED)
def test_assembled_arms_pick(tmp_path, assembled):
    write, gripper = ASSEMBLED[assembled]
    check_cycles(pick(tmp_path, write(tmp_path), gripper, 20))
