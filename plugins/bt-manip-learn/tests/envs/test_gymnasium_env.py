"""Trees are environments of Gymnasium that keep its rules."""

import inspect
import json
import subprocess
import sys
import warnings

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from bt_manip.plugins import load_plugins
from bt_manip_learn.envs import environment_id

ID = "bt_manip/PickPlace-v0"
ACTIONS = tuple(load_plugins().parts.of("actions"))

pytestmark = pytest.mark.filterwarnings("ignore:.*WARN.*:UserWarning")


@pytest.fixture(scope="module")
def env():
    env = gymnasium.make(ID, action="joint_targets", reward="dense", disable_env_checker=True)
    yield env
    env.close()


def digest(env, seed, steps=4):
    """Return the sums of the observations of random steps."""
    observation, _ = env.reset(seed=seed)
    env.action_space.seed(seed)
    sums = [sum(float(x.sum()) for x in observation.values())]
    for _ in range(steps):
        observation, *_ = env.step(env.action_space.sample())
        sums.append(sum(float(x.sum()) for x in observation.values()))
    return sums


@pytest.mark.parametrize("action", ACTIONS)
def test_gymnasium_accepts_the_environment_and_random_actions_give_finite_observations(action):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        run_random_policy(ID, action, 12)
    texts = [str(one.message) for one in found]
    assert all("observation space m" in text or "spec" in text for text in texts), texts


def test_another_process_has_the_same_observations_and_imports_gymnasium_only_for_these(env):
    code = (
        "import bt_manip, bt_manip_learn.agents, json, sys\n"
        "assert 'gymnasium' not in sys.modules\n"
        "import gymnasium\n"
        f"env = gymnasium.make('bt_manip_learn.envs:{ID}', disable_env_checker=True)\n"
        f"{inspect.getsource(digest)}\n"
        "print(json.dumps(digest(env, 7)))\n"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(found.stdout) == digest(env, 7)
    assert digest(env, 8) != digest(env, 7)


@pytest.mark.soak
@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.parametrize("tree", load_plugins().parts.trees)
def test_every_tree_is_an_environment_for_long(tree, action):
    run_random_policy(environment_id(tree), action, 10_000)


def run_random_policy(id, action, steps):
    env = gymnasium.make(id, action=action, reward="dense", disable_env_checker=True)
    check_env(env.unwrapped, skip_render_check=True)
    env.reset(seed=0)
    env.action_space.seed(0)
    for _ in range(steps):
        observation, reward, terminated, truncated, _ = env.step(env.action_space.sample())
        assert -1.0 <= reward <= 2.0
        assert all(np.isfinite(x).all() for x in observation.values())
        if terminated or truncated:
            env.reset()


def test_a_choice_of_subtrees_can_succeed():
    env = gymnasium.make(ID, action="subtree_choice", reward="dense", disable_env_checker=True)
    _, info = env.reset(seed=0)
    choices = env.unwrapped.task.action.space.choices
    rewards = []
    for part in ("attempt/pick", "attempt/Drop::21"):
        number = next(i for i, name in enumerate(choices) if name == part)
        for _ in range(100):
            _, reward, terminated, _, info = env.step(number)
            rewards.append(reward)
            if terminated or env.unwrapped.task.action.status.name != "RUNNING":
                break
    assert info["is_success"] and rewards[-1] > 1.0 > max(rewards[:-1])
    assert sum(rewards[:-1]) > 0.0  # progress, before success
