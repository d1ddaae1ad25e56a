"""The pick and place task by arms that are far smaller than the one it was made for."""

from pathlib import Path

import pytest

from bt_manip.record.report.recorder import Recorder
from bt_manip.record.report.run_report import RunReport
from bt_manip.registry import Parts
from bt_manip.runner import RunRequest, find_tree, prepare
from tests.support.small_arm import write_small_arm


def run(parts: Parts, robot: Path, tree: str = "pick_place", **request) -> RunReport:
    source = find_tree(tree, {name: parts.trees.get(name) for name in parts.trees})
    recorder = Recorder(tree, 0)
    prepare(RunRequest(source, robot=str(robot), **request), parts).execute([recorder])
    return recorder.report()


def test_a_half_metre_arm_picks_without_a_tree_or_scene_of_its_own(parts, tmp_path):
    report = run(parts, write_small_arm(tmp_path), cycles=1)
    assert [cycle.status for cycle in report.cycles] == ["SUCCESS"]


@pytest.mark.soak
def test_a_half_metre_arm_picks_close_cubes(parts, tmp_path):
    report = run(parts, write_small_arm(tmp_path), "pick_place_cluttered")
    assert [cycle.status for cycle in report.cycles] == ["SUCCESS"]


def test_a_weak_gripper_that_opens_too_little_picks_a_smaller_cube(parts, tmp_path):
    report = run(parts, write_small_arm(tmp_path, opening=0.04, force=20.0), cycles=1)
    assert [cycle.status for cycle in report.cycles] == ["SUCCESS"]


def test_region_and_heights_can_be_set(parts, tmp_path):
    settings = {"region": "0.0;0.05;0.2;0.25", "height": "0.12", "drop_height": "0.19"}
    report = run(parts, write_small_arm(tmp_path), cycles=1, settings=settings)
    assert [cycle.status for cycle in report.cycles] == ["SUCCESS"]
