"""bt-manip run --snapshot-at and --resume: left at any moment, gone on from to the same end."""

import errno
import itertools
import json
import os
import signal

import pytest

from bt_manip.cli.app import run_app
from bt_manip.runner import load_snapshot, save_snapshot
from tests.support.program import run_python


def test_a_run_that_goes_on_ends_as_the_one_that_was_never_left(digest, trees, tmp_path):
    moment = tmp_path / "moment.json"
    tree = f"{trees}:quick"
    whole = digest(tree, "--seed", 3, "--cycles", 3)
    assert digest(tree, "--seed", 3, "--cycles", 3, "--snapshot-at", 0.04, moment) == whole
    assert digest(tree, "--cycles", 3, "--resume", moment) == whole  # the seed is the snapshot's


def test_a_varied_run_goes_on_in_another_process(digest, task, tmp_path):
    moment, report = tmp_path / "moment.json", tmp_path / "rest.json"
    tree = task('<Sequence><SpawnObject object="{o}"/><Hover object="{o}"/></Sequence>')
    scene = ("--scene", "varied_pick")
    whole, _ = digest(tree, *scene, "--snapshot-at", 0.25, moment)
    files = "--resume", moment, "--report", report
    run_python("-m", "bt_manip", "run", tree, *scene, "--quiet", *files, cwd=tmp_path)
    rest = json.loads(report.read_text())
    assert rest["state_digest"] == whole
    assert rest["cycles"][0]["randomized"]["objects"]["cube"]["mass"] > 0.0  # spawned before


def test_a_moment_that_never_comes_is_a_warning(bt_manip, trees, tmp_path):
    moment = tmp_path / "moment.json"
    code, _, err = bt_manip("run", f"{trees}:quick", "--quiet", "--snapshot-at", 60, moment)
    assert code == 0
    assert "the run ended at 0." in err
    assert not moment.exists()


def test_another_request_is_refused_before_anything_is_simulated(bt_manip, trees, tmp_path):
    moment, named = tmp_path / "moment.json", tmp_path / "named.toml"
    named.write_text("[configurations]\nthere = [0, -0.785, 0, -2.356, 0, 1.571, 0.785]\n")
    bt_manip("run", f"{trees}:quick", "--snapshot-at", 0.01, moment)
    changes = (
        ("--seed", 5, "--cycles", 2, "--tick", 20, "--speed", 0.5, "--tool-speed", 0.5),
        ("--controller", "gravity_compensated_pd", "--set", "name=basket", "--stub-unknown"),
        ("--vary", "controller.kp=900", "--fault", "push at=rest", "--configurations", named),
    )
    code, _, err = bt_manip("run", f"{trees}:quick", "--resume", moment, *itertools.chain(*changes))
    assert code == 2 and "moment.json is of another run: " in err
    for message in (
        "seed 0 instead of 5", "cycles 1 instead of 2", "tick 0.01 instead of 0.02",
        "speed 1.0 instead of 0.5", "tool_speed None instead of 0.5",
        "controller 'computed_torque' instead of 'gravity_compensated_pd'",
        "settings name None instead of 'basket'", "foreign stub_unknown None instead of True",
        "varied controller.kp None instead of 900",
        "modifiers fault None instead of ['push at=rest']",
        "configurations there None instead of",
    ):  # fmt: skip
        assert message in err
    watched = "--quiet", "--real-time", 50, "--report", tmp_path / "report.json"
    assert bt_manip("run", f"{trees}:quick", "--resume", moment, *watched).code == 0
    code, _, err = bt_manip("run", f"{trees}:quick", "--resume", moment, "--episode", 0)
    assert code == 2 and "is of another run: episode None instead of 0" in err
    code, _, err = bt_manip("run", f"{trees}:endless", "--resume", moment)
    assert code == 2
    assert "tree 'small_trees.py:quick' instead of 'small_trees.py:endless'" in err


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"request": {}, "run": 1, "recorder": 2}, "is no snapshot of a run"),
        ({"request": {}, "run": {}, "recorder": {}}, "does not say what was run"),
    ],
)
def test_a_file_that_is_no_snapshot_of_a_run_is_refused(
    bt_manip, trees, tmp_path, content, message
):
    save_snapshot(tmp_path / "moment.json", content)
    code, _, err = bt_manip("run", f"{trees}:quick", "--resume", tmp_path / "moment.json")
    assert code == 2 and message in err


def test_a_run_goes_on_without_room_for_its_snapshot(bt_manip, trees, tmp_path, monkeypatch):
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("bt_manip.runner.snapshot.replace_text", full)
    report = tmp_path / "report.json"
    code, _, err = bt_manip(
        "run", f"{trees}:quick", "--snapshot-at", 0.01, tmp_path / "x.json", "--report", report
    )
    assert code == 3 and "No space left on device; the run continues" in err
    assert "internal fault" not in err
    assert [one["status"] for one in json.loads(report.read_text())["cycles"]] == ["SUCCESS"]


def test_an_interrupt_while_a_snapshot_is_written_leaves_it_whole(
    interrupt, trees, tmp_path, monkeypatch
):
    replace, folder = os.replace, tmp_path / "kept"
    folder.mkdir()

    def interrupted(*paths):
        signal.raise_signal(signal.SIGINT)
        replace(*paths)

    monkeypatch.setattr("os.replace", interrupted)
    options = "--quiet", "--snapshot-at", "0.03", str(folder / "moment.json")
    assert run_app(interrupt, ["run", f"{trees}:endless", *options]) == 130
    assert [path.name for path in folder.iterdir()] == ["moment.json"]
    assert load_snapshot(folder / "moment.json")["run"]
