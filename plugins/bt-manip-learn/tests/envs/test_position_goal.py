"""Goals are positions of objects, reached if and only if the goal of the tree holds."""

import gymnasium
import numpy as np
import pytest

import bt_manip_learn.envs  # noqa: F401 (registers the environments)
from bt_manip.cell import extent
from bt_manip.exceptions import BtManipError
from bt_manip.spatial import pose
from bt_manip_learn.envs import LearningTask
from bt_manip_learn.envs.gymnasium_env import GymnasiumEnvironment


def test_relabelled_goals_are_positions_of_the_object():
    env = GymnasiumEnvironment("pick_place", goal_conditioned=True)
    observation, _ = env.reset(seed=0)
    assert set(observation) == {"observation", "achieved_goal", "desired_goal"}
    assert env.observation_space.contains(observation)
    cell = env.task.episodes.station.cell
    achieved, desired = observation["achieved_goal"], observation["desired_goal"]
    np.testing.assert_allclose(achieved[:3], cell.pose("cube").translation, atol=1e-7)
    basket = np.mean(extent(cell, "basket"), axis=0)
    np.testing.assert_allclose(desired, [*basket, 1.0], atol=1e-6)
    near, beside = achieved + [[0.049, -0.049, 0.049, 0.0], [0.0, -0.051, 0.0, 0.0]]
    found = np.stack([near, beside, [*desired[:3], 0.0], desired])
    assert env.compute_reward(found, np.stack([achieved] * 4), [{}] * 4).tolist() == [0, -1, -1, -1]
    assert env.compute_reward(found, np.stack([desired] * 4), [{}] * 4).tolist() == [-1, -1, -1, 0]
    after, reward, *_, info = env.step(np.zeros(env.action_space.shape, np.float32))
    assert reward == env.compute_reward(after["achieved_goal"], after["desired_goal"], info) == -1.0


def steps_of_the_expert(env, seed, disturbed):
    """Yield the goals after each step; disturbed: the object is put elsewhere now and then."""
    observation, _ = env.reset(seed=seed)
    task, rng = env.task, np.random.default_rng(seed)
    cell = task.episodes.station.cell
    goal = task.episodes.run.tree.goal[0]
    name, destination = goal.object, getattr(goal, goal.destination)
    for _ in range(1200):
        yield env.result(task.expert_step())[0]
        if task.episodes.ended:
            return
        if disturbed and rng.random() < 0.1 and name in cell.entities:
            place = cell.pose(destination).translation + rng.uniform(-0.15, 0.15, 3)
            cell.move(name, pose(place + [0, 0, 0.15]), overlap=1.0)


QUICK = [("pick_place", False), ("pick_place_cluttered", False), ("pick_place_cluttered", True)]

TREES = [
    pytest.param(tree, disturbed, marks=() if (tree, disturbed) in QUICK else pytest.mark.soak)
    for tree in (one.kwargs["tree"] for one in gymnasium.registry.values() if "tree" in one.kwargs)
    if not tree.endswith("_seen")  # the expert of these needs cameras
    for disturbed in (False, True)
]


@pytest.mark.parametrize(("tree", "disturbed"), TREES)
def test_a_goal_is_reached_if_and_only_if_that_of_the_tree_holds(tree, disturbed):
    goal = LearningTask(tree).episodes.run.tree.goal
    if not all(getattr(one, "destination", "") for one in goal):
        with pytest.raises(BtManipError, match="not a position"):
            GymnasiumEnvironment(tree, goal_conditioned=True)
        return
    env = GymnasiumEnvironment(tree, goal_conditioned=True)
    reached = []
    for goals in steps_of_the_expert(env, 1, disturbed):
        reward = env.compute_reward(goals["achieved_goal"], goals["desired_goal"], {})
        reached.append(reward == 0.0)
        assert reached[-1] == (not env.task.episodes.run.goal.why_not())
    assert disturbed or reached.count(True) == 1 and reached[-1]
