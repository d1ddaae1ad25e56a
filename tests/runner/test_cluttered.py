"""Three cubes that lie close together, taken one after the other."""

import pytest

from bt_manip.record.report.recorder import Recorder
from bt_manip.runner import RunRequest, find_tree, prepare


def run(parts, **request):
    tree = find_tree("pick_place_cluttered", {n: parts.trees.get(n) for n in parts.trees})
    recorder = Recorder("pick_place_cluttered", request.get("seed", 0))
    prepare(RunRequest(tree, **request), parts).execute([recorder])
    return recorder.report()


def all_taken(report) -> bool:
    return all(c.status == "SUCCESS" and c.unexpected_contacts == () for c in report.cycles)


def test_all_three_cubes_are_taken_and_nothing_else_is_touched(parts):
    assert all_taken(run(parts, seed=3))


@pytest.mark.soak
def test_three_hundred_of_three_hundred_cubes_are_taken(parts):
    report = run(parts, seed=11, cycles=100)
    assert len(report.cycles) == 100 and all_taken(report)
