"""The pick and place task by arms of other sizes and joints than the one it was made for."""

from pathlib import Path

import pytest

from tests.support.small_arm import write_small_arm

from .conftest import report_of

MODELS = Path(__file__).parents[1] / "robots/models"


def succeeds(parts, robot: Path, tree: str = "pick_place", **request) -> bool:
    report = report_of(parts, tree, robot=str(robot), cycles=1, **request)
    return [cycle.status for cycle in report.cycles] == ["SUCCESS"]


@pytest.mark.parametrize("robot", ["five_joints", "rail"])
def test_pick_place_succeeds_with(parts, robot):
    assert succeeds(parts, MODELS / f"{robot}.toml")


WEAK = {"opening": 0.04, "force": 20.0}  # it picks a smaller cube
SETTINGS = {"region": "0.0;0.05;0.2;0.25", "height": "0.12", "drop_height": "0.19"}


@pytest.mark.parametrize(
    ("arm", "options"),
    [
        ({}, {}),
        (WEAK, {}),
        ({}, {"settings": SETTINGS}),
        pytest.param({}, {"tree": "pick_place_cluttered"}, marks=pytest.mark.soak),
    ],
)
def test_a_half_metre_arm_picks_without_a_scene_of_its_own(parts, tmp_path, arm, options):
    assert succeeds(parts, write_small_arm(tmp_path, **arm), **options)
