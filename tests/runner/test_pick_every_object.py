"""What is registered as graspable can be picked and placed."""

import pytest

from bt_manip.plugins import load_plugins
from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import RunRequest, find_tree, prepare

PARTS = load_plugins(entry_points=()).parts
GRASPABLE = [n for n in PARTS.objects.names() if PARTS.objects.get(n).category == "graspable"]


@pytest.mark.soak
@pytest.mark.parametrize("seed", [0, 1, 2])
@pytest.mark.parametrize("name", GRASPABLE)
def test_it_is_picked_and_dropped_into_the_basket(name, seed):
    source = find_tree("pick_place", {n: PARTS.trees.get(n) for n in PARTS.trees})
    recorder = Recorder("pick_place", seed)
    prepare(RunRequest(source, settings={"cube": name}, seed=seed), PARTS).execute([recorder])
    cycle = recorder.report().cycles[0]
    assert cycle.status == "SUCCESS", cycle.reason
    assert cycle.placed
    assert cycle.unexpected_contacts == ()
