"""``--fault`` of ``run`` and ``evaluate`` disturbs the same episodes in the same way."""

import json

import pytest

from bt_manip.evaluation import Evaluation, evaluate
from bt_manip.exceptions import BtManipError

pytestmark = pytest.mark.usefixtures("shared_stations")

FAULT = "sensor_noise at=rest"


def options(*faults):
    return {"modifiers": {"fault": faults}} if faults else {}


def test_an_evaluation_in_processes_has_the_episodes_of_single_runs(bt_manip, trees, tmp_path):
    tree, report = f"{trees}:quick", tmp_path / "report.json"
    found = evaluate(Evaluation(tree, options(FAULT)), episodes=2, workers=2)
    digests = {one.episode: one.digest for one in found}
    for episode, digest in digests.items():
        arguments = "--seed", 0, "--episode", episode, "--fault", FAULT
        assert bt_manip("run", tree, *arguments, "--report", report).code == 0
        assert json.loads(report.read_text())["state_digest"] == digest
    undisturbed = {one.episode: one.digest for one in evaluate(Evaluation(tree), episodes=2)}
    assert all(undisturbed[episode] != digest for episode, digest in digests.items())


def test_a_real_robot_has_no_faults(bt_manip, trees):
    code, _, err = bt_manip("run", f"{trees}:quick", "--backend", "any=1", "--fault", FAULT)
    assert code == 2 and "--fault needs a simulation, not --backend any=1" in err


def test_a_fault_at_a_node_that_the_tree_does_not_have_is_bad_input(bt_manip, trees):
    code, _, err = bt_manip("run", f"{trees}:quick", "--fault", "push at=nap")
    assert code == 2 and err.startswith("Error: fault 'push': the tree has no node 'nap'; known: ")
    with pytest.raises(BtManipError, match="the tree has no node 'nap'"):
        list(evaluate(Evaluation(f"{trees}:quick", options("push at=nap")), episodes=1))


def test_an_evaluation_without_the_fault_in_any_episode_has_measured_nothing(
    bt_manip, trees, in_this_process
):
    never = "vanish at=rest object=ghost", "push at=rest cycle=3"
    words = [word for fault in (*never, FAULT) for word in ("--fault", fault)]
    code, _, err = bt_manip("evaluate", f"{trees}:quick", "--episodes", 2, *words)
    faults = " or ".join(f"the fault '{fault}'" for fault in reversed(never))
    assert code == 1 and f"no episode had {faults}: nothing was measured." in err
    code, _, err = bt_manip("run", f"{trees}:quick", "--fault", never[1])
    assert code == 0 and f"'{never[1]}' did not happen: there was no cycle 3" in err


def test_results_of_other_faults_are_not_continued_and_a_failed_one_is_watched_with_its_own(
    bt_manip, trees, tmp_path, in_this_process
):
    pytest.importorskip("pyarrow")
    words = "evaluate", f"{trees}:quick", "--episodes", 1, "--to", tmp_path / "out"
    code, out, _ = bt_manip(*words, "--fault", "exception at=rest")
    assert code == 1 and "--fault 'exception at=rest' --episode 0 --view" in out.replace("\n", " ")
    code, _, err = bt_manip(*words)
    assert code == 2 and "is of another evaluation: modifiers fault" in err
