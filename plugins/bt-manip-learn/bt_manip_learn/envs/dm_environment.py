"""dm_env environment of a tree."""

from typing import Any

import dm_env
import numpy as np
from dm_env import specs

from .learning_task import LearningTask, Outcome


class DmEnvironment(dm_env.Environment):
    """dm_env environment of a tree's task, on the same entities as a run.

    An episode ends with discount 0 when the goal of the tree holds, when it can no longer be
    reached, or when the physics diverges; with discount 1 at the time limit.

    Args:
        tree: The tree, as in ``bt-manip run``.
        seed: Seed of all episodes, which are numbered from 0.
        time_limit: Longest simulated time of an episode [s].
        **options: Options of `LearningTask`: ``robot``, ``action``, ``reward``, ``images``, ...

    Attributes:
        task: The task.
        outcome: Outcome of the last step; None at the start of an episode.

    Raises:
        BtManipError: If an option is invalid, or the tree declares no goal.
    """

    def __init__(
        self, tree: str, *, seed: int = 0, time_limit: float = 60.0, **options: Any
    ) -> None:
        self.task = LearningTask(tree, **options)
        self._seed, self._episode = seed, -1
        self._steps = round(time_limit / self.task.episodes.step_time)
        self._ended = True
        self.outcome: Outcome | None = None

    def reset(self) -> dm_env.TimeStep:
        """Start the next episode."""
        self._episode += 1
        self.task.reset(self._seed, self._episode)
        self._ended, self.outcome = False, None
        return dm_env.restart(self.task.observe())

    def step(self, action: Any) -> dm_env.TimeStep:
        """Make one step, or start the next episode if the last one has ended."""
        if self._ended:
            return self.reset()
        self.outcome = self.task.step(action)
        observation = self.task.observe()
        if self.outcome.success or self.outcome.failure:
            self._ended = True
            return dm_env.termination(self.outcome.reward, observation)
        if self.task.episodes.steps >= self._steps:
            self._ended = True
            return dm_env.truncation(self.outcome.reward, observation)
        return dm_env.transition(self.outcome.reward, observation)

    def observation_spec(self) -> dict[str, specs.Array]:
        """Return shape and data type of each observation, by name."""
        return {
            name: specs.Array(spec.shape, spec.dtype, name)
            for name, spec in self.task.observations.specs.items()
        }

    def action_spec(self) -> specs.BoundedArray:
        """Return the bounds of continuous actions, or the number of discrete ones."""
        space = self.task.action.space
        if space.choices:
            return specs.DiscreteArray(len(space.choices), np.int64, "action")
        name = "\t".join(space.names)  # as dm_control names the numbers of an action
        return specs.BoundedArray(space.shape, space.dtype, space.low, space.high, name)

    def reward_spec(self) -> specs.BoundedArray:
        """Return the bounds of rewards."""
        low, high = self.task.reward_bounds
        return specs.BoundedArray((), float, low, high, "reward")

    def close(self) -> None:
        """End recordings, and free the renderers."""
        self.task.close()
