"""The pick and place task by arms of five joints and on a rail."""

from pathlib import Path

import pytest

from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import RunRequest, find_tree, prepare

MODELS = Path(__file__).parents[1] / "robots/models"


@pytest.mark.parametrize("robot", ["five_joints", "rail"])
def test_pick_place_succeeds_with(parts, robot):
    source = find_tree("pick_place", {"pick_place": parts.trees.get("pick_place")})
    recorder = Recorder("pick_place", 0)
    request = RunRequest(source, robot=str(MODELS / f"{robot}.toml"), cycles=1)
    prepare(request, parts).execute([recorder])
    assert [cycle.status for cycle in recorder.report().cycles] == ["SUCCESS"]
