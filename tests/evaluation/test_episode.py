"""An episode gives one result, which depends on the seed and its number alone."""

import json
from dataclasses import replace
from functools import partial
from unittest.mock import Mock

import pytest

from bt_manip.cell import CellError
from bt_manip.cell.randomization import Randomizer
from bt_manip.evaluation import EpisodeId, EpisodeWorker, SuccessRate, run_episodes
from bt_manip.exceptions import BtManipError


def run(worker, *episodes, point=0):
    return [worker.run(EpisodeId(point, episode)) for episode in episodes]


def test_a_result_tells_the_samples_and_the_node_that_failed_and_depends_on_its_number_alone(
    evaluation,
):
    results = run(EpisodeWorker(evaluation()), *range(4))
    assert {result.status for result in results} == {"SUCCESS", "FAILURE"}
    for result in results:
        mass = json.loads(result.randomized)["objects"]["cube"]["mass"]
        assert result.success == (mass < 0.1)
        assert result.node == ("" if result.success else "check")
        assert result.reason == ("" if result.success else f"{mass:.3f} kg is heavy")
        assert 0.05 <= result.duration_s < 0.1 and len(result.digest) == 64
    for other in run(EpisodeWorker(evaluation()), 2, 0, 2):
        assert replace(results[other.episode], wall_s=other.wall_s) == other


def test_picks_of_a_fixture_have_the_same_digests_in_any_order(evaluation, tmp_path):
    scene = {"scene": str(tmp_path / "fixture.toml")}
    forth, back = (
        run(EpisodeWorker(evaluation("pick", options=scene)), *order) for order in ((0, 1), (1, 0))
    )
    assert [one.status for one in forth] == ["SUCCESS"] * 2
    assert [one.digest for one in forth] == [one.digest for one in back[::-1]]
    assert forth[0].digest != forth[1].digest


def test_success_without_the_goal_is_a_failure_of_the_goal(evaluation):
    (result,) = run(EpisodeWorker(evaluation("trusting")), 0)
    assert (result.status, result.node, result.goal) == ("FAILURE", "goal", False)
    assert result.reason == "the cell has no object 'no'"


def test_an_episode_that_does_not_end_names_the_leaf_that_ran(evaluation):
    worker = EpisodeWorker(evaluation("endless", timeout=0.2))
    first, again = run(worker, 0, 0)
    assert (first.status, first.node) == ("TIMEOUT", "wait")
    assert first.reason == "no end within 0.2 s simulated" and first.digest == again.digest


@pytest.mark.parametrize(
    ("name", "node", "reason"), [("loud", "shout", "so loud"), ("leaving", "", "SystemExit")]
)
def test_any_exception_but_an_interrupt_is_a_failure_of_the_episode(evaluation, name, node, reason):
    first, again = run(EpisodeWorker(evaluation(name)), 0, 0)
    assert first.status == "ERROR" and reason in first.reason and node in first.node
    assert first.digest == again.digest


def test_episodes_whose_state_diverges_in_the_grip_are_failed_rows(evaluation, tmp_path):
    options = {"scene": str(tmp_path / "fixed.toml"), "settings": {"limit": 0.1}}
    diverged, after = run(EpisodeWorker(evaluation("fragile", options=options)), 3, 0)
    masses = [json.loads(one.randomized)["objects"]["cube"]["mass"] for one in (diverged, after)]
    assert masses[0] > 0.1 > masses[1]
    assert (diverged.success, diverged.status) == (False, "ERROR")
    assert diverged.reason.startswith("PhysicsDiverged: MuJoCo warned")
    assert diverged.duration_s > 0.5
    assert (after.success, after.status, after.node) == (False, "FAILURE", "goal")
    (fresh,) = run(EpisodeWorker(evaluation("fragile", options=options)), 0)
    assert fresh.digest == after.digest


def test_a_leaf_that_a_fallback_replaced_is_in_the_row(evaluation):
    results = run(EpisodeWorker(evaluation("rescued")), 0, 1)
    assert [json.loads(one.leaf_times) for one in results] == [
        {"Policy": {"share": 0.0, "reasons": ["does not fit"]}}
    ] * 2
    assert [json.loads(one.rescues) for one in results] == [{"or": 1}] * 2
    rate = SuccessRate.of(results)
    assert rate.recoveries() == [("or", "rescues", 2, 2, 2)]
    assert str(rate).startswith("2 of 2 episodes succeeded")
    assert rate.use.sentences("episodes") == [
        "Policy ran in 0 of 2 episodes, for 0.0% of the time: 2 x does not fit."
    ]


def test_points_vary_tree_scene_robot_and_controller(evaluation):
    points = (
        {"limit": 0.2}, {"scene.objects.cube.mass": 0.3}, {"robot.velocity": 0.5},
        {"controller.kp": 2000},
    )  # fmt: skip
    worker = EpisodeWorker(evaluation(points=points))
    found = [run(worker, 0, point=point)[0] for point in range(4)]
    assert [result.success for result in found[:2]] == [True, False]
    assert len({result.digest for result in found}) >= 3


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("limitt", "no key 'limitt'; did you mean 'limit'"),
        ("controller.kpp", "controller 'computed_torque' has no 'kpp'; did you mean 'kp'"),
        ("controller.robot", "has no 'robot'; known: friction_velocity, kd, ki, kp$"),
        ("robot.velcity", "robot 'panda' has no 'velcity'; did you mean 'velocity'"),
        ("robot.gripper.forc", "robot 'panda': gripper has no 'forc'"),
        ("scene.objects.mass", "is no parameter of a scene"),
        ("scen.objects.cube.mass", "nothing is called .*; did you mean 'scene'"),
    ],
)
def test_unknown_parameters_are_refused(evaluation, name, problem):
    with pytest.raises(BtManipError, match=problem):
        EpisodeWorker(evaluation(points=({name: 1.0},)))


def test_an_episode_that_does_not_begin_is_no_failure_of_the_tree(evaluation, monkeypatch):
    worker = EpisodeWorker(evaluation())
    monkeypatch.setattr(Randomizer, "begin", Mock(side_effect=CellError("no free pose")))
    (result,) = run(worker, 0)
    assert (result.status, result.success) == ("UNSTARTED", False)
    assert "no free pose" in result.reason


@pytest.mark.soak
def test_picks_of_a_fixture_have_the_same_digests_with_one_and_three_workers(evaluation, tmp_path):
    scene = {"scene": str(tmp_path / "fixture.toml")}
    make = partial(EpisodeWorker, evaluation("pick", options=scene))
    episodes = [EpisodeId(0, number) for number in range(12)]
    one, three = (
        {result.episode: result.digest for result in run_episodes(make, episodes, workers)}
        for workers in (1, 3)
    )
    assert one == three and len(set(one.values())) == 12
