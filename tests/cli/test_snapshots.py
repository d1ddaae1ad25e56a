"""bt-manip run --snapshot-at and --resume: left at any moment, gone on from to the same end."""

import errno
import json
import os
import signal
import subprocess
import sys
import textwrap
import time

import pytest

from bt_manip.runner import save_snapshot


@pytest.fixture
def digest(bt_manip, tmp_path):
    """Run a tree and give the digest of its report."""

    def digest(tree, *options) -> str:
        report = tmp_path / "report.json"
        outcome = bt_manip("run", tree, "--quiet", "--report", report, *options)
        assert outcome.code == 0, outcome.err
        return json.loads(report.read_text())["state_digest"]

    return digest


def test_a_run_that_goes_on_ends_as_the_one_that_was_never_left(digest, trees, tmp_path):
    moment = tmp_path / "moment.json"
    tree = f"{trees}:quick"
    whole = digest(tree, "--seed", 3, "--cycles", 3)
    assert digest(tree, "--seed", 3, "--cycles", 3, "--snapshot-at", 0.04, moment) == whole
    assert digest(tree, "--cycles", 3, "--resume", moment) == whole  # the seed is the snapshot's


def test_a_varied_run_goes_on_in_another_process(digest, tmp_path):
    moment, report = tmp_path / "moment.json", tmp_path / "rest.json"
    scene = ("--scene", "varied_pick")
    whole = digest("pick_place", *scene, "--snapshot-at", 1.25, moment)
    command = [sys.executable, "-m", "bt_manip", "run", "pick_place", *scene, "--quiet"]
    command += ["--resume", str(moment), "--report", str(report)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
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
    for options, message in (
        (("--seed", 5), "is of another run: seed 0 instead of 5"),
        (("--controller", "gravity_compensated_pd"), "controller 'computed_torque' instead of"),
        (("--set", "name=basket"), "settings name None instead of 'basket'"),
        (("--cycles", 2), "cycles 1 instead of 2"),
        (("--speed", 0.5), "speed 1.0 instead of 0.5"),
        (("--tool-speed", 0.5), "tool_speed None instead of 0.5"),
        (("--tick", 20), "tick 0.01 instead of 0.02"),
        (("--stub-unknown",), "foreign stub_unknown None instead of True"),
        (("--vary", "controller.kp=900"), "varied controller.kp None instead of 900"),
        (("--fault", "push at=rest"), "modifiers fault None instead of ['push at=rest']"),
        (("--configurations", named), "configurations there None instead of"),
    ):
        code, _, err = bt_manip("run", f"{trees}:quick", "--resume", moment, *options)
        assert (code, message in err) == (2, True), err
    watched = "--quiet", "--real-time", 50, "--report", tmp_path / "report.json"
    assert bt_manip("run", f"{trees}:quick", "--resume", moment, *watched).code == 0
    code, _, err = bt_manip("run", f"{trees}:endless", "--resume", moment)
    assert code == 2
    assert "tree 'small_trees.py:quick' instead of 'small_trees.py:endless'" in err


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ({"cell": 1}, "is no snapshot of a run"),
        ({"request": {}, "run": 1, "recorder": 2}, "is no snapshot of a run"),
        ({"request": {}, "run": {}, "recorder": {}}, "does not say what was run"),
        (
            {"request": {}, "run": {}, "recorder": {}, "identity": {}},
            "is of another run: configurations None instead of {}",
        ),
    ],
)
def test_a_file_that_is_no_snapshot_of_a_run_is_refused(
    bt_manip, trees, tmp_path, content, message
):
    moment = tmp_path / "moment.json"
    save_snapshot(moment, content)
    code, _, err = bt_manip("run", f"{trees}:quick", "--resume", moment)
    assert code == 2
    assert message in err


def test_where_no_snapshot_can_be_written_nothing_is_run(bt_manip, trees, tmp_path):
    code, _, err = bt_manip("run", f"{trees}:quick", "--snapshot-at", 1, tmp_path / "no" / "x.json")
    assert code == 2
    assert "snapshot" in err
    same = tmp_path / "x.json"
    code, _, err = bt_manip("run", f"{trees}:quick", "--snapshot-at", 1, same, "--report", same)
    assert code == 2
    assert "report and snapshot cannot both be" in err
    assert list(tmp_path.glob("*.json")) == []


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


def test_an_interrupted_run_leaves_whole_snapshots_only(trees, tmp_path):
    # Snapshots without end: whenever the interrupt comes, one is likely being written.
    (tmp_path / "go.py").write_text(
        textwrap.dedent(f"""
            import sys
            from bt_manip.__main__ import main
            sys.argv = ["bt-manip", "run", "{trees}:endless", "--quiet"]
            for i in range(400):
                sys.argv += ["--snapshot-at", str(0.01 * i), f"{{i}}.json"]
            main()
            """)
    )
    folder = tmp_path / "kept"
    folder.mkdir()
    process = subprocess.Popen([sys.executable, tmp_path / "go.py"], cwd=folder)
    while not list(folder.glob("[0-9]*.json")):
        time.sleep(0.05)
        assert process.poll() is None
    os.kill(process.pid, signal.SIGINT)
    assert process.wait(timeout=60) == 130
    kept = sorted(folder.iterdir())
    assert kept
    assert [path for path in kept if path.suffix != ".json" or path.name.startswith(".")] == []
    for path in kept:
        json.loads(path.read_text())
