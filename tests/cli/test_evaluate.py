"""bt-manip evaluate and sweep: what they print, write and return."""

import json
import os
from functools import partial
from importlib.util import find_spec

import pytest

from bt_manip.cli.app import run_app
from bt_manip.cli.exit_codes import BAD_INPUT, FAULT, exit_code_of
from bt_manip.evaluation import EpisodeWorker, WorkerDiedError, call_in_process
from bt_manip.exceptions import BtManipError
from tests.evaluation.conftest import SCENE, TREES


@pytest.fixture
def evaluate(bt_manip, tmp_path):
    (tmp_path / "small.py").write_text(TREES)
    (tmp_path / "cube.toml").write_text(SCENE)

    def run(*options, command="evaluate", tree="light"):
        words = f"{tmp_path}/small.py:{tree}", "--scene", tmp_path / "cube.toml", "--workers", 1
        return bt_manip(command, *words, *options)

    return run


@pytest.fixture(autouse=True)
def one_worker(monkeypatch) -> None:
    """Let the worker that has checked an evaluation run its episodes: building one takes long."""
    made: dict[str, EpisodeWorker] = {}

    def make(evaluation):
        key = repr((evaluation.tree, evaluation.options, evaluation.points))
        if key not in made:
            made[key] = EpisodeWorker(evaluation)
        return made[key]

    monkeypatch.setattr("bt_manip.evaluation.EpisodeWorker", make)
    monkeypatch.setattr("bt_manip.evaluation.scheduling.EpisodeWorker", make)


def test_the_rate_the_reasons_and_what_to_look_at_are_printed(
    evaluate, in_this_process, bt_manip, tmp_path
):
    code, out, _ = evaluate("--episodes", 4)
    assert code == 1
    assert "of 4 episodes succeeded" in out and "kg is heavy" in out
    (advice,) = [line for line in out.splitlines() if line.startswith("Watch")]
    words = advice.partition(": bt-manip ")[2].split()
    assert words[-1] == "--view"
    report = tmp_path / "report.json"
    assert bt_manip(*words[:-1], "--quiet", "--report", report).code == 1
    assert "kg is heavy" in json.loads(report.read_text())["cycles"][0]["reason"]


def test_episodes_that_end_their_process_are_failed_rows(evaluate, in_this_process, monkeypatch):
    def die(make_worker, episodes, workers, *, pool, lost):
        error = WorkerDiedError("its process ended with exit code 0")
        return (lost(episode, error) for episode in episodes)

    monkeypatch.setattr("bt_manip.evaluation.scheduling.run_episodes", die)
    code, out, _ = evaluate("--episodes", 1)
    assert code == 1 and "its process ended with exit code 0" in out


def test_a_process_that_died_is_a_fault_and_no_bad_input():
    with pytest.raises(WorkerDiedError) as died:
        call_in_process("the undisturbed cycle", partial(os._exit, 7))
    assert exit_code_of(died.value) == FAULT
    assert exit_code_of(BtManipError("no such tree")) == BAD_INPUT


def test_results_are_continued_and_others_refused(evaluate, in_this_process, tmp_path):
    pytest.importorskip("pyarrow")
    folder = tmp_path / "out"
    options = "--set", "limit=1", "--to", folder
    code, out, _ = evaluate("--episodes", 1, *options)
    assert code == 0 and "No episode failed" in out and f"bt-manip report {folder}" in out
    code, out, err = evaluate("--episodes", 2, *options)
    assert code == 0 and "2 of 2 episodes" in out and "1 episodes are known already" in err
    code, _, err = evaluate("--episodes", 2, "--to", folder)
    assert code == 2 and "of another evaluation: settings limit" in err


def test_a_sweep_prints_a_row_for_each_point_and_is_drawn(
    evaluate, in_this_process, bt_manip, tmp_path
):
    pytest.importorskip("pyarrow")
    pytest.importorskip("viser")
    words = "--vary", "scene.objects.cube.mass=0.05,0.2", "--episodes", 1, "--to", tmp_path / "out"
    code, out, _ = evaluate(*words, command="sweep")
    assert bt_manip("report", tmp_path / "out").code == 0
    assert "scene.objects.cube.mass" in (tmp_path / "out.html").read_text()
    assert code == 1 and "scene.objects.cube.mass" in out
    assert "0.05" in out and "100.0%" in out and "0.0%" in out


def test_two_values_are_compared_on_the_same_episodes(evaluate, in_this_process):
    words = "--vary", "limit=0.0001,10", "--episodes", 4
    code, out, _ = evaluate(*words, command="sweep")
    assert "A: limit=0.0001" in out and "B: limit=10" in out
    assert "0 succeeded with both, 0 with A only, 4 with B only, 0 with neither" in out
    assert "p = 0.125" in out  # 2 / 2**4
    assert "A alone failed in episodes 0, 1, 2, 3" in out
    for episode in range(4):
        assert f"--set limit=0.0001 --episode {episode} --view" in out


def test_the_command_of_a_differing_episode_repeats_it(
    evaluate, in_this_process, bt_manip, tmp_path
):
    words = "--vary", "scene.objects.cube.mass=0.02,0.3", "--episodes", 2, "--set", "limit=0.1"
    _, out, _ = evaluate(*words, command="sweep")
    commands = [line.split()[1:-1] for line in out.splitlines() if line.startswith("  bt-manip")]
    assert len(commands) == 2 and "--vary" in commands[1]
    report = tmp_path / "report.json"
    assert bt_manip(*commands[1], "--quiet", "--report", report).code == 1
    found = json.loads(report.read_text())
    assert found["varied"] == {"scene.objects.cube.mass": 0.3}
    assert found["cycles"][0]["randomized"]["objects"]["cube"]["mass"] == 0.3
    code, _, err = bt_manip(*commands[1], "--vary", "controller.kp=1,2")
    assert code == 2 and "--vary controller.kp: a run has one value" in err


def test_two_trees_are_compared_and_stopping_early_biases(evaluate, in_this_process, tmp_path):
    (tmp_path / "other.py").write_text(TREES)
    code, out, _ = evaluate(f"{tmp_path}/other.py:light", "--episodes", 2)
    assert "0 with A only, 0 with B only" in out and "p = 1" in out
    assert "alone failed" not in out and "biases" not in out
    _, out, _ = evaluate("--episodes", 1, "--until-interval", 0.5)
    assert "biases rates slightly upwards" in " ".join(out.split())


@pytest.mark.parametrize(
    ("command", "options", "problem"),
    [
        ("evaluate", ("a", "b"), "one tree is evaluated, or two are compared, got 3"),
        ("evaluate", ("pick_place", "--until-interval", 0.1), "both need all episodes"),
        ("sweep", ("--vary", "a"), "--vary is KEY=VALUE"),
        ("sweep", ("--vary", "limit=1", "--vary", "limit=2"), "--vary gives 'limit' twice"),
        ("sweep", ("--vary", "limit=0..1"), "a range needs its number of values"),
        ("sweep", ("--vary", "limitt=1"), "has no key 'limitt'"),
    ],
)
def test_bad_input_is_found_first(evaluate, command, options, problem):
    code, out, err = evaluate(*options, command=command)
    assert code == 2 and problem in " ".join(err.split()) and out == ""


def test_without_a_server_a_cluster_is_refused(evaluate):
    if find_spec("ray") is None:
        pytest.skip("the extra [ray] is not installed")
    code, _, err = evaluate("--ray", "127.0.0.1:1")
    assert code == 2 and "--ray 127.0.0.1:1: there is no cluster at HOST:PORT" in err


PRESSING = """
import signal
from bt_manip.bt import Action, Status

class Press(Action):
    pressed = 0

    def update(self):
        Press.pressed += 1
        if Press.pressed == 3:
            signal.raise_signal(signal.SIGINT)
        return Status.SUCCESS

def press():
    return Press()
"""


def test_ctrl_c_prints_the_results_so_far(interrupt, in_this_process, tmp_path, capfd):
    (tmp_path / "press.py").write_text(PRESSING)
    words = "evaluate", f"{tmp_path}/press.py:press", "--workers", "1", "--episodes", "100"
    assert run_app(interrupt, [*words]) == 130
    out, err = capfd.readouterr()
    assert "2 of 2 episodes succeeded" in out and "Traceback" not in err


def test_a_quantity_of_an_object_that_never_was_in_the_cell_has_no_rate(in_this_process, evaluate):
    words = "--vary", "scene.objects.bottle.mass=0.1,0.2", "--episodes", 1
    code, out, err = evaluate(*words, command="sweep")
    assert code == 1
    assert "nothing named 'bottle' was in the cell (scene.objects.bottle.mass)" in err
    assert "%" not in out and "McNemar" not in out
