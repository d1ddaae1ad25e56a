"""A tree as an environment of Gymnasium."""

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from bt_manip.episodes import ActionSpace, Images, Observations, ObservationSpec

from .learning_task import LearningTask

RENDERED = Images(("rgb",), ("overview",), 640, 480)
"""The rendered image."""


class GymnasiumEnvironment(gymnasium.Env[dict[str, np.ndarray], Any]):
    """The task of a tree as an environment of Gymnasium.

    An episode is terminated when the goal of the tree holds, when it cannot be met any more, or
    when the physics diverges; Gymnasium's wrapper for the time limit truncates it. ``info`` has
    ``success``, ``failure`` (why the goal cannot be met any more), and ``seed`` and ``episode``,
    which identify the episode.

    Attributes:
        task: The task.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 20}

    def __init__(self, tree: str, render_mode: str | None = None, **options: Any) -> None:
        """Prepare the environment.

        Args:
            tree: The tree, as in ``bt-manip run``.
            render_mode: ``"rgb_array"``, or None for no images from `render`.
            **options: Those of `LearningTask`: ``robot``, ``action``, ``reward``, ``images``, ...

        Raises:
            BtManipError: If an option is invalid, or the tree declares no goal.
        """
        self.task = LearningTask(tree, **options)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1 / self.task.episodes.step_time)}
        observations = self.task.observations
        last = len(observations.entities) - 1
        self.observation_space: Any = spaces.Dict(
            {name: _box(spec, last) for name, spec in observations.specs.items()}
        )
        self.action_space = _action_space(self.task.action.space)
        self._rendered: Observations | None = None
        self._seed: int | None = None
        self._episode = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, np.ndarray], dict[str, Any]]:
        """Start an episode.

        Args:
            seed: Seed of this episode and of those after it; None: the next episode.
            options: ``episode``, the number of the episode, or ``state``, one of `get_state` to
                continue from.

        Raises:
            BtManipError: If the episode cannot be started.
        """
        super().reset(seed=seed)
        options = options or {}
        if seed is not None:
            self._seed, self._episode = seed, 0
        elif self._seed is None:
            self._seed = int(self.np_random.integers(2**31))
        else:
            self._episode += 1
        if "state" in options:
            self.set_state(options["state"])
        else:
            self._episode = int(options.get("episode", self._episode))
            self.task.reset(self._seed, self._episode)
        return self.task.observe(), self._info(False, "")

    def step(self, action: Any) -> tuple[dict[str, np.ndarray], float, bool, bool, dict[str, Any]]:
        """Make one step; see `gymnasium.Env`."""
        reward, success, failure = self.task.step(action)
        info = self._info(success, failure)
        return self.task.observe(), reward, success or bool(failure), False, info

    def render(self) -> np.ndarray | None:
        """Return an image of the overview camera; None without a render mode."""
        if self.render_mode is None:
            return None
        if self._rendered is None:
            station = self.task.episodes.station
            self._rendered = Observations(station.cell, station.robots, RENDERED)
        return next(iter(self._rendered.images().values()))

    def close(self) -> None:
        """Free what renders images."""
        for observations in (self.task.observations, self._rendered):
            if observations is not None:
                observations.close()

    def get_state(self) -> dict[str, Any]:
        """Return the state of the episode as plain data."""
        return self.task.get_state()

    def set_state(self, state: dict[str, Any]) -> None:
        """Continue an episode from a state, bit for bit, also in another process."""
        self.task.set_state(state)
        self._seed, self._episode = self.task.episodes.seed, self.task.episodes.episode

    def _info(self, success: bool, failure: str) -> dict[str, Any]:
        identity = {"seed": self._seed, "episode": self._episode}
        return {"success": success, "failure": failure, **identity}


def _box(spec: ObservationSpec, last: int) -> spaces.Box:
    """Return the space of an observation; ``last`` is the largest number in a segmentation."""
    low, high = 0.0, {"uint8": 255, "int32": last}.get(spec.dtype, np.inf)
    if len(spec.shape) == 1:
        low = -np.inf
    return spaces.Box(low, high, spec.shape, np.dtype(spec.dtype).type)


def _action_space(space: ActionSpace) -> spaces.Space[Any]:
    if space.choices:
        return spaces.Discrete(len(space.choices))
    return spaces.Box(space.low, space.high, dtype=np.float32)
