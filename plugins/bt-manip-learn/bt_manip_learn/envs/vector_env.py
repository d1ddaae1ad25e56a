"""Gymnasium vector environment of a tree, in one process."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space, concatenate, create_empty_array, iterate
from mujoco.batch import Batch as Simulations

from bt_manip.exceptions import BtManipError

from .batch import Batch
from .gymnasium_env import GymnasiumEnvironment
from .registration import MAX_EPISODE_STEPS

NOT_FOR_ONE = frozenset(
    {"step", "reset", "close", "get_state", "set_state", "expert_step", "expert_action"}
)
"""Methods of an environment that change the physics, or need what a batch does not keep of one."""


class BatchEnvironment(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """Vector environment of a tree: environments with one model, stepped by MuJoCo's threads.

    Observations, rewards and ends equal those of single environments with the controller
    ``native_pd``, bit for bit, for any number of threads. Methods, spaces and ``info`` are those of
    Gymnasium's ``SyncVectorEnv``.

    Args:
        tree: The tree, as in ``bt-manip run``.
        num_envs: Number of environments.
        max_episode_steps: Steps after which an episode is truncated; None: never.
        autoreset_mode: When to reset an environment that has ended; see Gymnasium.
        threads: Number of simulation threads; 0: one per CPU.
        **options: Options of `GymnasiumEnvironment`; ``controller`` is ``"native_pd"``.

    Attributes:
        env: The single environment whose code serves all environments.
        autoreset_mode: When an environment that has ended is reset.

    Raises:
        BtManipError: If an option is invalid, or the task cannot be batched.
    """

    def __init__(
        self,
        tree: str,
        num_envs: int = 1,
        *,
        max_episode_steps: int | None = MAX_EPISODE_STEPS,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        threads: int = 0,
        **options: Any,
    ) -> None:
        self._first_seed: int | None = options.pop("seed", None)
        if num_envs < 1:
            raise BtManipError(f"a batch has at least one environment, got {num_envs}")
        self.env = GymnasiumEnvironment(tree, **{"controller": "native_pd", **options})
        try:
            self._batch = Batch(self.env, num_envs, threads)
        except BaseException:
            self.env.close()
            raise
        self.num_envs = num_envs
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.render_mode = self.env.render_mode
        self.metadata = {**self.env.metadata, "autoreset_mode": self.autoreset_mode}
        self.single_observation_space = self.env.observation_space
        self.single_action_space = self.env.action_space
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._max_steps = max_episode_steps
        self._steps = np.zeros(num_envs, dtype=int)
        self._ended = np.zeros(num_envs, dtype=bool)
        self._observations: list[Any] = [None] * num_envs

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Any, dict[str, Any]]:
        """Start an episode in each environment, or in those selected by a mask.

        Args:
            seed: Seed of the first environment, incremented for each further one; or one each. In
                the first call the option ``seed`` of the environments is the default.
            options: Options of `GymnasiumEnvironment.reset`, and ``reset_mask``: which environments
                to reset. A ``state`` is that of a single environment with the same options.

        Raises:
            BtManipError: If an episode cannot be started.
        """
        options = dict(options or {})
        seed, self._first_seed = self._first_seed if seed is None else seed, None
        mask = options.pop("reset_mask", np.ones(self.num_envs, dtype=bool))
        if seed is None or isinstance(seed, int):
            seed = [None if seed is None else seed + i for i in range(self.num_envs)]
        if len(seed) != self.num_envs or np.shape(mask) != (self.num_envs,):
            raise BtManipError(
                f"a batch of {self.num_envs} environments has as many seeds, and its 'reset_mask' "
                f"as many entries; got {len(seed)} and {np.shape(mask)}"
            )
        infos: dict[str, Any] = {}
        for i in np.flatnonzero(mask).tolist():
            infos = self._add_info(infos, self._reset(i, seed[i], options), i)
        return self._gathered(), infos

    def step(self, actions: Any) -> tuple[Any, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Make one step in each environment; see `gymnasium.vector.VectorEnv`."""
        n = self.num_envs
        rewards, ends, limits = np.zeros(n), np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)
        resetting = self._ended & (self.autoreset_mode is AutoresetMode.NEXT_STEP)
        if self.autoreset_mode is AutoresetMode.DISABLED and self._ended.any():
            raise BtManipError(
                "an environment has ended, and autoreset is disabled: reset it with 'reset_mask'"
            )
        moving = np.flatnonzero(~resetting)
        given = list(iterate(self.action_space, actions))
        for i in moving.tolist():
            if not np.isfinite(given[i]).all():
                raise BtManipError(f"the action of environment {i} is not finite: {given[i]}")
        units = [self.env.in_units(given[i]) for i in moving.tolist()]
        infos: dict[str, Any] = {}
        for i in np.flatnonzero(resetting).tolist():
            infos = self._add_info(infos, self._reset(i, None, {}), i)
        for i, result in zip(
            moving.tolist(), self._batch.step(moving.tolist(), units), strict=True
        ):
            observation, rewards[i], ends[i], _, info = result
            self._observations[i] = observation
            self._steps[i] += 1
            limits[i] = self._max_steps is not None and self._steps[i] >= self._max_steps
            self._ended[i] = ends[i] or limits[i]
            if self._ended[i] and self.autoreset_mode is AutoresetMode.SAME_STEP:
                infos = self._add_info(infos, {"final_obs": observation, "final_info": info}, i)
                info = self._reset(i, None, {})
            infos = self._add_info(infos, info, i)
        return self._gathered(), rewards, ends, limits, infos

    def render(self) -> tuple[Any, ...]:
        """Return the image of each environment, see `GymnasiumEnvironment.render`."""
        return self.call("render")

    def call(self, name: str, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        """Return the results of a method that reads each environment, or their attribute.

        Raises:
            BtManipError: If the method changes the physics, which is that of the batch, or copies
                what a batch does not keep.
        """
        if name in NOT_FOR_ONE:
            raise BtManipError(f"'{name}' is not possible in single environments of a batch")

        def read() -> Any:
            found = getattr(self.env, name)
            return found(*args, **kwargs) if callable(found) else found

        return tuple(self._batch.within(i, read) for i in range(self.num_envs))

    def get_attr(self, name: str) -> tuple[Any, ...]:
        """Return an attribute of each environment."""
        return self.call(name)

    def set_attr(self, name: str, values: Any) -> None:
        """Set an attribute of all environments, which share it: to one value.

        Raises:
            BtManipError: If the values differ, or are not one for each environment.
        """
        given = values if isinstance(values, list | tuple) else [values] * self.num_envs
        if len(given) != self.num_envs or any(
            value is not given[0] and value != given[0] for value in given[1:]
        ):
            raise BtManipError(f"environments of a batch share '{name}': set one value for all")
        setattr(self.env, name, given[0])

    @property
    def simulations(self) -> list[Simulations]:
        """MuJoCo's simulations of groups of environments, in the order of their numbers."""
        return self._batch.groups

    def close_extras(self, **kwargs: Any) -> None:
        """Free the simulations."""
        self.env.close()

    def _reset(self, i: int, seed: int | None, options: dict[str, Any]) -> dict[str, Any]:
        """Start an episode in one environment; return its ``info``."""
        self._observations[i], info = self._batch.reset(i, seed, options)
        self._steps[i], self._ended[i] = 0, False
        return info

    def _gathered(self) -> Any:
        """Return the observations of all environments, in new arrays."""
        space = self.single_observation_space
        if any(one is None for one in self._observations):
            raise BtManipError("an environment was never reset: call reset() without a mask first")
        empty: Any = create_empty_array(space, n=self.num_envs)
        return concatenate(space, self._observations, empty)
