"""Every example is listed, runs, and does what it says."""

import re
import runpy
import shlex
from pathlib import Path

import pytest

from bt_manip.bt import ReadingOptions
from bt_manip.plugins import PluginSelection, load_plugins
from bt_manip.record import Recorder
from bt_manip.runner import RunLoop, RunRequest, find_tree, prepare
from tests.support.program import run_program, run_python

ROOT = Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "examples"
LISTING = (EXAMPLES / "README.md").read_text()

SAYS = {
    "1_pick_without_a_tree.py": (
        r"hold \('cube',\) with (4[89]|5\d)\.\d and (4[89]|5\d)\.\d N",
        r"joints within [01]\.\d+ mrad",
        r"'cube' has landed in the basket after [2-4]\.\d+ s",
    ),
    "2_first_tree.py": (
        r"50 N, after [2-4]\.\d+ s: SUCCESS",
        r"500 N, after .* s: FAILURE: .*Grasp::\d+: the gripper holds with up to 140 N, not 500 N",
    ),
    "3_the_same_in_xml.py": (
        r"as it is: SUCCESS",
        r"with 20 N: SUCCESS",
        r"with a typing error: 3_first_tree\.xml:17:7: .*'Raech'; did you mean 'Reach'",
    ),
    "4_own_behaviour.py": (r"SUCCESS, 5[67]\.\d g",),
    "5_own_object.py": (r"SUCCESS, after [2-4]\.\d+ s",),
    "6_learn_to_reach.py": (r"needs Stable-Baselines3",),  # tests/clients have it
}
"""What each example prints, line by line."""


def test_every_example_has_something_to_say():
    assert sorted(SAYS) == sorted(path.name for path in EXAMPLES.glob("*.py"))


def test_every_example_is_listed_and_nothing_else():
    linked = re.findall(r"\]\(([^)/]+)\)", LISTING)
    files = [path.name for path in EXAMPLES.iterdir() if path.suffix in (".py", ".xml", ".ipynb")]
    assert sorted(linked) == sorted(files)


@pytest.mark.parametrize("name", sorted(SAYS))
def test_an_example_runs_and_says(name, capsys):
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    out = capsys.readouterr().out
    for says in SAYS[name]:
        assert re.search(says, out), out


def commands(program: str) -> list[str]:
    return re.findall(rf"^\.venv/bin/{program} (.+)$", LISTING, re.MULTILINE)


@pytest.mark.parametrize("command", commands("bt-manip"))
def test_a_tree_runs_by_the_command_line_as_listed(command, monkeypatch, capfd):
    monkeypatch.chdir(ROOT)
    assert run_program(*shlex.split(command), "--quiet") == 0


@pytest.mark.parametrize(
    ("command", "passed"), [(*commands("pytest"), 3), ("examples/own_task", 4)]
)
def test_an_examples_own_tests_pass(command, passed):
    assert f"{passed} passed" in run_python("-m", "pytest", *shlex.split(command), cwd=ROOT)


def offset(cell, name, container):
    """Return the largest horizontal distance between two objects along an axis [m]."""
    return abs((cell.pose(name).translation - cell.pose(container).translation)[:2]).max()


def test_the_objective_of_moveit_pro_carries_the_cube_to_the_basket():
    folder = EXAMPLES / "moveit_pro"
    reading = ReadingOptions(dialect="auto", mapping=folder / "mapping.toml")
    tree, scene = find_tree(str(folder / "pick_and_place.xml"), {}), str(folder / "cell.toml")
    run = prepare(RunRequest(tree, scene=scene, reading=reading), load_plugins().parts)
    with RunLoop(run) as loop:
        ended = loop.cycle()
    assert ended.succeeded, ended.reason
    assert offset(run.station.cell, "cube", "basket") < 0.15


def test_the_task_of_ones_own_puts_each_object_into_its_bin_and_counts():
    folder = EXAMPLES / "own_task"
    parts = load_plugins(choice=PluginSelection(folders=(folder,))).parts
    tree, scene = find_tree(str(folder / "sort.xml"), {}), str(folder / "scene.toml")
    run = prepare(RunRequest(tree, scene=scene), parts)
    recorder = Recorder("sort", 0)
    run.execute([recorder])
    (cycle,) = recorder.report().cycles
    assert (cycle.status, cycle.reason) == ("SUCCESS", "")
    assert dict(cycle.results) == {"left": 2, "right": 2}
    bins = {"nut_1": "left_bin", "nut_2": "left_bin", "cube": "right_bin", "block": "right_bin"}
    assert all(offset(run.station.cell, *pair) < 0.1 for pair in bins.items())
