"""Arms that nobody described: their models become descriptions, which pick without any edit."""

import json
from pathlib import Path
from typing import Any

import pytest

from bt_manip.cli.app import run_app
from bt_manip.cli.interrupt import Interrupt
from bt_manip.models import bundled_path

GRIPPER = "robotiq_2f85/2f85.xml"
MENAGERIE = {
    "franka_emika_panda/panda.xml": None,
    "franka_fr3/fr3.xml": GRIPPER,
    "kuka_iiwa_14/iiwa14.xml": GRIPPER,
    "ufactory_xarm7/xarm7.xml": None,
    "universal_robots_ur5e/ur5e.xml": GRIPPER,
}
MORE = {
    "kinova_gen3/gen3.xml": GRIPPER,
    "trossen_vx300s/vx300s.xml": None,
    "trossen_wx250s/wx250s.xml": None,
    "trs_so_arm100/so_arm100.xml": None,
}


def pick(folder: Path, model: Path, gripper: Path | None, cycles: int) -> list[dict[str, Any]]:
    """Describe a robot from its model and return the cycles of pick_place with it."""
    file, report = folder / "robot.toml", folder / "report.json"
    carried = [] if gripper is None else ["--gripper", str(gripper)]
    assert (
        run_app(
            Interrupt(), ["robot", "new", str(model), *carried, "--cycles", "0", "-o", str(file)]
        )
        == 0
    )
    command = ["run", "pick_place", "--robot", str(file), "--cycles", str(cycles), "--quiet"]
    run_app(Interrupt(), [*command, "--report", str(report)])
    return list(json.loads(report.read_text())["cycles"])


def check_cycles(cycles: list[dict[str, Any]]) -> None:
    for cycle in cycles:
        assert cycle["status"] == "SUCCESS", cycle["reason"]
        assert not cycle["unexpected_contacts"]


def test_the_bundled_arm_picks_as_described_from_its_model(tmp_path):
    check_cycles(pick(tmp_path, bundled_path("panda/panda.xml"), None, 2))


def test_an_arm_with_a_gripper_of_another_model_picks(tmp_path, menagerie):
    arm, gripper = menagerie / "universal_robots_ur5e" / "ur5e.xml", menagerie / GRIPPER
    check_cycles(pick(tmp_path, arm, gripper, 2))


def test_an_arm_with_a_turning_jaw_picks_at_the_first_attempt(tmp_path, more_models):
    cycles = pick(tmp_path, more_models / "trs_so_arm100" / "so_arm100.xml", None, 1)
    check_cycles(cycles)
    assert {phase["status"] for phase in cycles[0]["phases"]} == {"SUCCESS"}
    assert cycles[0]["max_tracking_error_rad"] < 1e-3 and cycles[0]["limits"]["effort"] < 1.0


@pytest.mark.soak
@pytest.mark.parametrize("model", MENAGERIE)
def test_arms_of_menagerie_pick(tmp_path, menagerie, model):
    gripper = MENAGERIE[model]
    check_cycles(pick(tmp_path, menagerie / model, gripper and menagerie / gripper, 20))


@pytest.mark.soak
@pytest.mark.parametrize("model", MORE)
def test_further_arms_of_menagerie_pick(tmp_path, more_models, model):
    gripper = MORE[model]
    check_cycles(pick(tmp_path, more_models / model, gripper and more_models / gripper, 20))
