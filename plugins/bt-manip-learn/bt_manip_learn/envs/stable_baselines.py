"""Batch of environments for Stable-Baselines3, which it requires."""

from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode
from stable_baselines3.common.vec_env import VecEnv

from .vector_env import BatchEnvironment


class BatchVecEnv(VecEnv):
    """A `BatchEnvironment` as a vector environment of Stable-Baselines3.

    Args:
        tree: The tree, as in ``bt-manip run``.
        num_envs: Number of environments.
        **options: Options of `BatchEnvironment` except ``autoreset_mode``.

    Attributes:
        batch: The batch.

    Raises:
        BtManipError: If an option is invalid, or the task cannot be batched.
    """

    def __init__(self, tree: str, num_envs: int, **options: Any) -> None:
        self.batch = BatchEnvironment(
            tree, num_envs, autoreset_mode=AutoresetMode.SAME_STEP, **options
        )
        single = self.batch.single_observation_space
        super().__init__(num_envs, single, self.batch.single_action_space)
        self._actions: Any = None

    def reset(self) -> Any:
        """Start an episode in each environment; return the observations."""
        observations, infos = self.batch.reset(seed=self._seeds)
        self.reset_infos = _separated(infos, self.num_envs)
        self._reset_seeds()
        self._reset_options()
        return observations

    def step_async(self, actions: np.ndarray) -> None:
        """Store the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Make one step in each environment."""
        observations, rewards, ends, limits, infos = self.batch.step(self._actions)
        separated, dones = _separated(infos, self.num_envs), ends | limits
        for i in np.flatnonzero(dones).tolist():
            last, at_end = separated[i].pop("final_obs"), separated[i].pop("final_info")
            self.reset_infos[i] = separated[i]
            separated[i] = {**at_end, "terminal_observation": last}
        for i, info in enumerate(separated):
            info["TimeLimit.truncated"] = bool(limits[i] and not ends[i])
        return observations, rewards.astype(np.float32), dones, separated

    def close(self) -> None:
        """Free the simulations."""
        self.batch.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """Return an attribute of the single environment for each environment."""
        return [getattr(self.batch.env, attr_name) for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refuse: environments of a batch share their attributes."""
        raise NotImplementedError("environments of a batch have no attributes of their own")

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Refuse: environments of a batch share their methods."""
        raise NotImplementedError("environments of a batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """Return False for each environment."""
        return [False for _ in self._get_indices(indices)]


def _separated(infos: dict[str, Any], count: int) -> list[dict[str, Any]]:
    """Split the ``info`` of a batch into that of each environment."""
    found: list[dict[str, Any]] = [{} for _ in range(count)]
    for key, values in infos.items():
        if key.startswith("_"):
            continue
        rows = _separated(values, count) if isinstance(values, dict) else values.tolist()
        for i in np.flatnonzero(infos[f"_{key}"]).tolist():
            found[i][key] = rows[i]
    return found
