"""``bt-manip stress``: the table, the files it writes, and its exit codes."""

import json

import pytest

from bt_manip_stress import StressEpisode, StressPhase, StressResult, StressTable
from bt_manip_stress.commands import print_table

pytestmark = pytest.mark.usefixtures("shared_stations")

TREE = """
import os

from bt_manip.behaviours import ObjectExists, SpawnObject
from bt_manip.bt import Action, AlwaysFailure, Input, Sequence, Sleep, Status, Tree


def tree(goal="{object}"):
    task = Sequence("task", SpawnObject(object="{object}"), Sleep("work", msec=200))
    return Tree(task, goal=ObjectExists(object=goal) if goal else ())


def aimless():
    return tree("")


class Leave(Action):
    least = Input(float, doc="Mass of the cube with which the process ends [kg].")

    def setup(self, **infrastructure):
        self.cell = infrastructure["cell"]

    def update(self):
        if self.cell.overrides.get("cube", {}).get("mass", 0.0) >= self.least:
            os._exit(0)
        return Status.SUCCESS


def leaving(least=0.0):
    task = tree().root
    task.add_child(Leave(least=least))
    return Tree(task, goal=ObjectExists(object="{object}"))


def failing():
    return Tree(AlwaysFailure(), goal=ObjectExists(object="table"))
"""


@pytest.fixture
def stress(bt_manip, tmp_path):
    path = tmp_path / "small.py"
    path.write_text(TREE)
    return lambda *options, name="tree": bt_manip(
        "stress", f"{path}:{name}", "--workers", 1, *options
    )


def test_a_table_and_its_page_are_written(stress, in_this_process, tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Stress\n\n<!-- stress -->\nold\n<!-- /stress -->\n\nAfter.\n")
    code, out, err = stress("--faults", "heavy, push", "--markdown", page)
    assert (code, err) == (0, "")
    assert "heavy  R1" in out and "2 faults: 2 recovered, 0 failed" in out
    text = page.read_text()
    assert text.startswith("# Stress\n\n<!-- stress -->\nMade by `bt-manip stress")
    assert "| push | R1 |" in text and text.endswith("<!-- /stress -->\n\nAfter.\n")


def test_the_episodes_are_printed_as_json_and_a_new_page_holds_the_table_alone(
    stress, in_this_process, tmp_path
):
    page = tmp_path / "page.md"
    options = "--tool-speed", "0.9", "--faults", "heavy, push", "--phases", "work"
    code, out, err = stress(*options, "--markdown", page, "--json")
    assert (code, err) == (0, "")
    found = json.loads(out)
    assert [case["outcome"] for case in found["episodes"]] == ["recovered"] * 2
    assert found["findings"] == []
    first, *_ = page.read_text().splitlines()
    assert first.startswith("Made by `bt-manip stress")
    given = f"--tool-speed 0.9 --seeds 1 --faults 'heavy, push' --phases work --markdown {page}`"
    assert f" {given}" in first


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("--faults", "pusch"), "Error: unknown fault 'pusch'; did you mean 'push'"),
        (("--phases", "wrk"), "Error: no leaf 'wrk' runs in this tree; did you mean 'work'?"),
        (("--markdown", "/nowhere/page.md"), "Error: table '/nowhere/page.md' cannot be written"),
        (("--seeds", "0"), "Invalid value for '--seeds'"),
    ],
)
def test_bad_input_is_one_line(stress, in_this_process, options, problem):
    code, out, err = stress(*options)
    assert code == 2 and problem in err and out == ""


def test_trees_that_cannot_be_judged_are_refused(stress, in_this_process):
    code, _, err = stress(name="aimless")
    assert code == 2 and len(err.splitlines()) == 1
    assert "declares no goal to judge it by; add one to its main <BehaviorTree>" in err
    code, _, err = stress(name="failing")
    assert code == 2 and "fails without any fault: AlwaysFailure" in err


@pytest.mark.soak
def test_a_fault_with_which_the_process_ends_is_named_and_exits_with_1(stress):
    code, out, err = stress("--faults", "heavy,push", "--set", "least=5", name="leaving")
    assert (code, err) == (1, "")
    assert "2 faults: 1 recovered, 0 failed, 0 dishonest, 0 hung, 1 died" in out
    assert "heavy X (work 1): its process ended with exit code 0" in out


def test_a_tree_that_ends_its_process_is_refused(stress):
    code, out, err = stress("--faults", "push", name="leaving")
    assert (code, out) == (3, "")
    assert err == "Error: the undisturbed cycle: its process ended with exit code 0\n"


def test_wide_tables_are_split_and_many_phases_are_rows(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    phases = [StressPhase(f"phase {i}", f"a/phase {i}", 1.0) for i in range(5)]

    def lines(faults):
        episodes = [StressEpisode(fault, phase, 0) for fault in faults for phase in phases]
        print_table(StressTable([StressResult(episode, "recovered") for episode in episodes]))
        return [line.split() for line in capsys.readouterr().out.splitlines()]

    assert lines(["push", "heavy"])[:2] == [["phase", "push", "heavy"], ["phase", "0", "R1", "R1"]]
    shown = lines([f"f{i}" for i in range(9)])
    assert shown[0] == ["fault", "phase", "0", "phase", "1", "phase", "2"]
    assert shown[10] == ["fault", "phase", "3", "phase", "4"]


def test_ctrl_c_ends_at_once_with_the_table_so_far(terminal, tmp_path):
    (tmp_path / "small.py").write_text(TREE)
    page = tmp_path / "page.md"
    options = ("--faults", "push", "--seeds", "200", "--workers", "1", "--markdown", str(page))
    stress = terminal("stress", "small.py:tree", *options)
    stress.wait_for(b"[1-9]%")
    stress.interrupt()
    assert stress.end() == 130
    assert b"undisturbed cycles after them failed" in stress.shown
    assert b"Traceback" not in stress.shown and not page.exists()
