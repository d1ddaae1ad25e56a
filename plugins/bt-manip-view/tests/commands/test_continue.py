"""bt-manip replay --continue: a recorded run goes on in another process, to the same end."""

import json
import re
import subprocess
import sys

import pytest

from bt_manip.bt import NodeStatus
from bt_manip.plugins import load_plugins
from bt_manip.record import Recorder
from bt_manip.runner import RunObserver, RunRequest, find_tree, prepare
from bt_manip_recording import McapRecorder, Recording


class Intervene(RunObserver):
    """Pulls the cube while the arm approaches it, and lets a leaf fail once."""

    def run_started(self, run):
        self.run, self.failed = run, False

    def before_tick(self):
        requests, cell = self.run.interventions, self.run.station.cell
        if 0.3 < cell.time < 0.6:
            requests.pull("cube", [0.45, 0.1, 1.1], point=(0.0, 0.0, 0.02))
        elif 0.6 < cell.time < 0.61:
            requests.pull("cube", None)
        grasp = next(node for node in self.run.tree.nodes if node.registration == "Grasp")
        if not self.failed and grasp.engine_status is NodeStatus.RUNNING:
            self.failed = True
            requests.override(grasp.path, NodeStatus.FAILURE)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Record two cycles of a randomized pick with interventions, as the command line would."""
    path = tmp_path_factory.mktemp("recorded") / "run.mcap"
    parts = load_plugins().parts
    tree = find_tree("pick_place", {name: parts.trees.get(name) for name in parts.trees})
    run = prepare(RunRequest(tree, scene="varied_pick", seed=3, cycles=2), parts)
    recorder = Recorder("pick_place", 3)
    run.execute([recorder, McapRecorder(path), Intervene()])
    kinds = {event.data["kind"] for event in Recording(path).events("intervention")}
    assert kinds == {"perturbation", "override"}
    return path, recorder.report()


def digest_of(path, *options) -> str:
    report = path.with_suffix(".json")
    command = [sys.executable, "-m", "bt_manip", "replay", path, "--quiet", "--report", report]
    done = subprocess.run([*command, *options], capture_output=True, text=True, check=False)
    assert done.returncode in (0, 1) and done.stderr == ""
    return json.loads(report.read_text())["state_digest"]


@pytest.mark.parametrize("share", [pytest.param(0.3, marks=pytest.mark.soak), 0.8])
def test_another_process_ends_in_the_recorded_state(recorded, share, tmp_path):
    path, report = recorded
    again = tmp_path / "again.mcap"
    moment = share * report.simulated_s
    options = ("--record", again) if share == 0.3 else ()
    assert digest_of(path, "--continue", str(moment), *options) == report.state_digest
    if options:  # what was recorded of the rest can be continued itself
        assert digest_of(again, "--continue", str(moment + 0.5)) == report.state_digest


def test_bad_input_is_one_line(bt_manip, trees, recording):
    for options, message in (
        (("--tree", f"{trees}:quick"), "--tree needs --continue T"),
        (("--continue", 9.0), "run.mcap ends at 0.0.* s, before 9 s"),
        (("--continue", -1), "run.mcap has no snapshot at or before -1 s to continue from"),
        (("--report", "report.json"), "--report needs --continue T"),
    ):
        code, out, err = bt_manip("replay", recording, *options)
        assert (code, out) == (2, "")
        assert re.fullmatch(f"Error: .*{message}\n", err)


def test_code_that_a_recording_names_runs_only_if_the_user_names_it_and_it_is_the_recorded_one(
    bt_manip, trees, tmp_path, monkeypatch
):
    path, ran = tmp_path / "run.mcap", tmp_path / "ran"
    module = tmp_path / "of_a_stranger.py"
    module.write_text(trees.read_text())
    monkeypatch.syspath_prepend(tmp_path)
    for tree, file in ((f"{trees}:quick", trees), ("of_a_stranger:quick", module)):
        path.unlink(missing_ok=True)
        assert bt_manip("run", tree, "--record", path).code == 0
        sys.modules.pop("of_a_stranger", None)
        kept = file.read_text()
        go_on = "replay", path, "--quiet", "--continue", 0.01
        assert bt_manip(*go_on, "--tree", tree).code == 0
        sys.modules.pop("of_a_stranger", None)
        file.write_text(f"open({str(ran)!r}, 'w')\n{kept}")
        code, _, err = bt_manip(*go_on)
        assert code == 2 and f"say so with --tree {tree}\n" in err
        code, _, err = bt_manip(*go_on, "--tree", tree)
        assert code == 2 and f"{file} is not the file that was recorded" in err
        assert not ran.exists() and "of_a_stranger" not in sys.modules
        file.write_text(kept)


def test_what_the_recorded_tree_imports_runs_only_if_it_is_the_recorded_one(
    bt_manip, trees, tmp_path, monkeypatch
):
    path, ran, helper = (tmp_path / name for name in ("run.mcap", "ran", "helper_of_a_stranger.py"))
    helper.write_text("NAME = 'table'\n")
    trees.write_text(f"import {helper.stem}\n{trees.read_text()}")
    with monkeypatch.context() as patched:
        patched.syspath_prepend(tmp_path)
        assert bt_manip("run", f"{trees}:quick", "--record", path).code == 0
    sys.modules.pop(helper.stem)
    helper.write_text(f"open({str(ran)!r}, 'w')\n")
    go_on = "replay", path, "--quiet", "--continue", 0.01, "--tree", f"{trees}:quick"
    code, _, err = bt_manip(*go_on)
    assert code == 2 and f"{helper} is not the file that was recorded" in err
    assert not ran.exists()


def test_a_run_with_faults_is_refused(bt_manip, trees, tmp_path):
    path = tmp_path / "run.mcap"
    bt_manip("run", f"{trees}:quick", "--fault", "push at=rest", "--record", path)
    code, _, err = bt_manip("replay", path, "--continue", 0.01)
    assert code == 2 and "a run with --fault, which cannot be continued" in err
