"""An episode gives one result, which depends on the seed and its number alone."""

import json
from dataclasses import replace

import pytest

from bt_manip.evaluation import EpisodeId, EpisodeWorker
from bt_manip.exceptions import BtManipError


def run(worker, *episodes, point=0):
    return [worker.run(EpisodeId(point, episode)) for episode in episodes]


def test_a_result_tells_the_samples_and_the_node_that_failed(evaluation):
    results = run(EpisodeWorker(evaluation()), *range(6))
    assert {result.status for result in results} == {"SUCCESS", "FAILURE"}
    for result in results:
        mass = json.loads(result.randomized)["objects"]["cube"]["mass"]
        assert result.success == (mass < 0.1)
        assert result.node == ("" if result.success else "check")
        assert result.reason == ("" if result.success else f"{mass:.3f} kg is heavy")
        assert 0.05 <= result.duration_s < 0.1 and len(result.digest) == 64


def test_results_do_not_depend_on_earlier_episodes(evaluation):
    def results(*episodes):
        found = run(EpisodeWorker(evaluation()), *episodes)
        return {result.episode: replace(result, wall_s=0.0) for result in found}

    assert results(0, 1, 2, 3) == results(3, 1, 0, 2, 1)


def test_success_without_the_goal_is_a_failure_of_the_goal(evaluation):
    (result,) = run(EpisodeWorker(evaluation("trusting")), 0)
    assert (result.status, result.node, result.goal) == ("FAILURE", "goal", False)
    assert result.reason == "the cell has no object 'no'"


def test_an_episode_that_does_not_end_names_the_leaf_that_ran(evaluation):
    worker = EpisodeWorker(evaluation("endless", timeout=0.2))
    first, again = run(worker, 0, 0)
    assert (first.status, first.node) == ("TIMEOUT", "wait")
    assert first.reason == "no end within 0.2 s simulated" and first.digest == again.digest


def test_what_a_behaviour_raises_is_a_failure_of_the_episode(evaluation):
    first, again = run(EpisodeWorker(evaluation("loud")), 0, 0)
    assert first.status == "ERROR" and "so loud" in first.reason and "shout" in first.node
    assert first.digest == again.digest


def test_points_vary_tree_scene_robot_and_controller(evaluation):
    points = (
        {"limit": 0.2}, {"scene.objects.cube.mass": 0.02}, {"scene.objects.cube.mass": 0.3},
        {"robot.velocity": 0.5}, {"controller.kp": 2000},
    )  # fmt: skip
    worker = EpisodeWorker(evaluation(points=points))
    found = [run(worker, 0, point=point)[0] for point in range(5)]
    assert [result.success for result in found[:3]] == [True, True, False]
    assert len({result.digest for result in found}) >= 4
    assert found[0] == replace(run(worker, 0)[0], wall_s=found[0].wall_s)


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("limitt", "no key 'limitt'; did you mean 'limit'"),
        ("controller.kpp", "controller 'computed_torque' has no 'kpp'; did you mean 'kp'"),
        ("robot.velcity", "robot 'panda' has no 'velcity'; did you mean 'velocity'"),
        ("robot.gripper.forc", "robot 'panda': gripper has no 'forc'"),
        ("scene.objects.mass", "is no parameter of a scene"),
        ("scen.objects.cube.mass", "nothing is called .*; did you mean 'scene'"),
    ],
)
def test_unknown_parameters_are_refused(evaluation, name, problem):
    with pytest.raises(BtManipError, match=problem):
        EpisodeWorker(evaluation(points=({name: 1.0},)))


def test_a_worker_with_another_identity_is_refused(evaluation):
    identity = EpisodeWorker(evaluation()).identity
    EpisodeWorker(evaluation(identity=identity))
    other = {**identity, "versions": {**identity["versions"], "mujoco": "1.0"}}
    with pytest.raises(BtManipError, match="versions mujoco '.*' instead of '1.0'"):
        EpisodeWorker(evaluation(identity=other))
