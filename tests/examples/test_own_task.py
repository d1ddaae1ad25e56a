"""The task of one's own among the examples: its tests pass, and it is done."""

import subprocess
import sys
from pathlib import Path

from bt_manip.plugins import PluginSelection, load_plugins
from bt_manip.record import Recorder
from bt_manip.runner import RunRequest, find_tree, prepare

FOLDER = Path(__file__).resolve().parents[2] / "examples" / "own_task"


def test_its_own_tests_pass():
    pytest = [sys.executable, "-m", "pytest", "-q", str(FOLDER)]
    done = subprocess.run(pytest, capture_output=True, text=True)
    assert done.returncode == 0 and "4 passed" in done.stdout, done.stdout


def test_each_object_ends_in_its_bin_and_the_report_has_the_counts():
    parts = load_plugins(choice=PluginSelection(folders=(FOLDER,))).parts
    scene = str(FOLDER / "scene.toml")
    run = prepare(RunRequest(find_tree(str(FOLDER / "sort.xml"), {}), scene=scene), parts)
    recorder = Recorder("sort", 0)
    run.execute([recorder])
    (cycle,) = recorder.report().cycles
    assert (cycle.status, cycle.reason, dict(cycle.results)) == (
        "SUCCESS", "", {"left": 2, "right": 2}
    )  # fmt: skip
    cell = run.station.cell
    bins = {"nut_1": "left_bin", "nut_2": "left_bin", "cube": "right_bin", "block": "right_bin"}
    for name, container in bins.items():
        distance = cell.pose(name).translation - cell.pose(container).translation
        assert abs(distance[:2]).max() < 0.1
