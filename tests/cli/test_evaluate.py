"""bt-manip evaluate and sweep: what they print, write and return."""

import json
from importlib.util import find_spec

import pytest

from tests.evaluation.conftest import SCENE, TREES


@pytest.fixture
def evaluate(bt_manip, tmp_path):
    (tmp_path / "small.py").write_text(TREES)
    (tmp_path / "cube.toml").write_text(SCENE)

    def run(*options, command="evaluate", tree="light"):
        words = f"{tmp_path}/small.py:{tree}", "--scene", tmp_path / "cube.toml", "--workers", 1
        return bt_manip(command, *words, *options)

    return run


def test_the_rate_the_reasons_and_what_to_look_at_are_printed(
    evaluate, in_this_process, bt_manip, tmp_path
):
    code, out, _ = evaluate("--episodes", 6)
    assert code == 1
    assert "of 6 episodes succeeded" in out and "kg is heavy" in out
    (advice,) = [line for line in out.splitlines() if line.startswith("Watch")]
    words = advice.partition(": bt-manip ")[2].split()
    assert words[-1] == "--view"
    report = tmp_path / "report.json"
    assert bt_manip(*words[:-1], "--quiet", "--report", report).code == 1
    assert "kg is heavy" in json.loads(report.read_text())["cycles"][0]["reason"]


def test_episodes_that_end_their_process_are_failed_rows(evaluate):
    code, out, _ = evaluate("--episodes", 1, tree="leaving")
    assert code == 1 and "its process ended with exit code 0" in out


def test_results_are_continued_and_others_refused(evaluate, tmp_path):
    pytest.importorskip("pyarrow")
    folder = tmp_path / "out"
    options = "--set", "limit=1", "--to", folder
    code, out, _ = evaluate("--episodes", 2, *options)
    assert code == 0 and "No episode failed" in out and f"bt-manip report {folder}" in out
    code, out, err = evaluate("--episodes", 4, *options)
    assert code == 0 and "4 of 4 episodes" in out and "2 episodes are known already" in err
    code, _, err = evaluate("--episodes", 4, "--to", folder)
    assert code == 2 and "of another evaluation: settings limit" in err


def test_a_sweep_prints_a_row_for_each_point_and_is_drawn(
    evaluate, in_this_process, bt_manip, tmp_path
):
    pytest.importorskip("pyarrow")
    pytest.importorskip("viser")
    words = "--vary", "scene.objects.cube.mass=0.05,0.2", "--episodes", 2, "--to", tmp_path / "out"
    code, out, _ = evaluate(*words, command="sweep")
    assert bt_manip("report", tmp_path / "out").code == 0
    assert "scene.objects.cube.mass" in (tmp_path / "out.html").read_text()
    assert code == 1 and "scene.objects.cube.mass" in out
    assert "0.05" in out and "100.0%" in out and "0.0%" in out


def test_two_trees_are_compared_on_the_same_episodes(evaluate, in_this_process, tmp_path):
    (tmp_path / "other.py").write_text(TREES)
    light = f"{tmp_path}/other.py:light"
    code, out, _ = evaluate(light, "--episodes", 6)
    assert code == 1 and "0 with A only, 0 with B only" in out and "p = 1" in out
    assert "alone failed" not in out


def test_two_values_are_compared_on_the_same_episodes(evaluate, in_this_process):
    words = "--vary", "limit=0.0001,10", "--episodes", 8
    code, out, _ = evaluate(*words, command="sweep")
    assert "A: limit=0.0001" in out and "B: limit=10" in out
    assert "0 succeeded with both, 0 with A only, 8 with B only, 0 with neither" in out
    assert "p = 0.00781" in out  # 2 / 2**8
    assert "A alone failed in episodes 0, 1, 2, 3, 4, 5, 6, 7" in out
    for episode in range(8):
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


def test_stopping_early_says_that_it_biases(evaluate, in_this_process):
    _, out, _ = evaluate("--episodes", 2, "--until-interval", 0.5)
    assert "biases rates slightly upwards" in " ".join(out.split())


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("a", "b"), "one tree is evaluated, or two are compared, got 3"),
        (("pick_place", "--until-interval", 0.1), "both need all episodes"),
    ],
)
def test_comparisons_that_mean_nothing_are_refused(evaluate, options, problem):
    code, _, err = evaluate(*options)
    assert code == 2 and problem in " ".join(err.split())


@pytest.mark.parametrize(
    ("options", "problem"),
    [
        (("--vary", "a"), "--vary is KEY=VALUE"),
        (("--vary", "limit=1", "--vary", "limit=2"), "--vary gives 'limit' twice"),
        (("--vary", "limit=0..1"), "a range needs its number of values"),
        (("--vary", "limitt=1"), "has no key 'limitt'"),
    ],
)
def test_bad_input_is_found_first(evaluate, options, problem):
    code, out, err = evaluate(*options, command="sweep")
    assert code == 2 and problem in err and out == ""


def test_without_a_server_a_cluster_is_refused(evaluate):
    if find_spec("ray") is None:
        pytest.skip("the extra [ray] is not installed")
    code, _, err = evaluate("--ray", "127.0.0.1:1")
    assert code == 2 and "--ray 127.0.0.1:1: there is no cluster at HOST:PORT" in err


def test_ctrl_c_prints_the_results_so_far(terminal, tmp_path):
    (tmp_path / "small.py").write_text(TREES)
    (tmp_path / "cube.toml").write_text(SCENE)
    words = "small.py:light", "--scene", "cube.toml", "--workers", "2", "--episodes", "100000"
    running = terminal("evaluate", *words)
    running.wait_for(rb"[1-9]\d* of 100000 episodes")
    running.interrupt()
    assert running.end() == 130
    assert b"episodes succeeded" in running.shown and b"Traceback" not in running.shown


def test_a_quantity_of_an_object_that_never_was_in_the_cell_has_no_rate(in_this_process, evaluate):
    words = "--vary", "scene.objects.bottle.mass=0.1,0.2", "--episodes", 1
    code, out, err = evaluate(*words, command="sweep")
    assert code == 1
    assert "nothing named 'bottle' was in the cell (scene.objects.bottle.mass)" in err
    assert "%" not in out and "McNemar" not in out
