"""A new learning task, to move the tool to a cube, and its training with PPO in a batch.

Train for ten minutes: pip install stable-baselines3; python examples/6_learn_to_reach.py 10
"""

import importlib.util
import math
import sys
import time
from typing import Any

import numpy as np

from bt_manip.behaviours import Hover, ObjectCondition, Reach, SpawnObject
from bt_manip.bt import Input, Sequence, Tree

ENVIRONMENTS = 64
EPISODE = 60  # steps of 50 ms
DISCOUNT = 0.95
ROUND = 5  # rollouts of 32 steps of all environments between two evaluations


class IsNear(ObjectCondition):
    """Check that the tool is near an object."""

    distance = Input(float, default=0.05, doc="Largest distance of the tool from its origin [m].")

    def setup(self, **infrastructure: Any) -> None:
        """Store cell and arm."""
        super().setup(**infrastructure)
        self.arm = infrastructure["arm"]

    def away(self) -> float:
        """Return the distance of the tool from the object [m]."""
        tool = self.arm.robot.tool_pose.translation
        return float(np.linalg.norm(tool - self.cell.pose(self.object).translation))

    def why_not(self) -> str:
        """Return the distance as a reason if it is too large."""
        away = self.away()
        return f"the tool is {1e3 * away:.0f} mm away" if away > self.distance else ""

    def progress(self) -> float:
        """Return the progress for the dense reward, from 0 to 1 at the object."""
        return 1.0 - math.tanh(self.away() / 0.3)


def reach() -> Tree:
    """Add a cube to the table, and move the tool to it."""
    root = Sequence(
        "reach a cube",
        SpawnObject(object="{cube}"),
        Hover(object="{cube}", height=0.15),
        Reach(object="{cube}"),
    )
    return Tree(root, goal=IsNear(object="{cube}"))


def learn(minutes: float) -> None:
    """Train; print successes and return in 64 test episodes at intervals."""
    import torch
    from stable_baselines3 import PPO
    from stable_baselines3.common.vec_env import VecNormalize

    from bt_manip_learn.envs.stable_baselines import BatchVecEnv

    torch.set_num_threads(1)
    options = {"action": "cartesian_deltas", "reward": "dense"}
    batches = [
        BatchVecEnv(f"{__file__}:reach", ENVIRONMENTS, max_episode_steps=EPISODE, **options)
        for _ in range(2)
    ]
    env = VecNormalize(batches[0], norm_reward=False)
    test = VecNormalize(batches[1], norm_reward=False, training=False)
    test.obs_rms = env.obs_rms
    env.seed(0)
    model = PPO(
        "MultiInputPolicy", env, n_steps=32, batch_size=512, n_epochs=5, gamma=DISCOUNT,
        learning_rate=1e-3, policy_kwargs={"log_std_init": -1.0}, seed=0, device="cpu",
    )  # fmt: skip
    start = time.monotonic()
    while True:
        spent = (time.monotonic() - start) / 60.0
        met, rewards = evaluate(model, test)
        print(f"{spent:.1f} min, {model.num_timesteps} steps: {met:.0%}, return {rewards:.2f}")
        if spent >= minutes:
            break
        model.learn(ROUND * 32 * ENVIRONMENTS, reset_num_timesteps=False)
    env.close()
    test.close()


def evaluate(model: Any, env: Any) -> tuple[float, float]:
    """Return the share of successes and the mean return of the first episodes."""
    env.seed(1000)
    observations = env.reset()
    going, met = np.ones(env.num_envs, bool), np.zeros(env.num_envs, bool)
    total = np.zeros(env.num_envs)
    while going.any():
        actions = model.predict(observations, deterministic=True)[0]
        observations, rewards, ends, infos = env.step(actions)
        total += going * rewards
        met |= going & ends & [one["is_success"] for one in infos]
        going &= ~ends
    return float(met.mean()), float(total.mean())


if __name__ == "__main__":
    if importlib.util.find_spec("stable_baselines3"):
        learn(float(sys.argv[1]) if len(sys.argv) > 1 else 10.0)
    else:
        print("learning needs Stable-Baselines3: pip install stable-baselines3")
