"""Environments of trees for LeRobot's commands, which import this package; requires LeRobot.

``lerobot-eval --env.discover_packages_path=bt_manip_learn.lerobot --env.type=bt_manip ...``
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from lerobot.configs.types import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig

from bt_manip_learn.agents import ROBOT
from bt_manip_learn.envs.gymnasium_env import GymnasiumEnvironment
from bt_manip_learn.envs.registration import MAX_EPISODE_STEPS

ID = "bt_manip/LeRobot-v0"

STATE, OBJECTS = "agent_pos", "environment_state"

FEATURES = {
    "action": (FeatureType.ACTION, "action"),
    STATE: (FeatureType.STATE, "observation.state"),
    OBJECTS: (FeatureType.ENV, "observation.environment_state"),
}
"""Type and name of each feature in LeRobot."""


class LeRobotEnvironment(GymnasiumEnvironment):
    """Environment whose observations and actions are those of an export for LeRobot.

    Observations are ``agent_pos``, ``environment_state`` and ``pixels``, a dictionary of images by
    camera. Actions have physical units, and are clipped to their bounds.

    Args:
        tree: The tree, as in ``bt-manip run``.
        episode_length: Number of steps until truncation.
        **options: Options of `GymnasiumEnvironment`.

    Attributes:
        task_description: The sentence that describes the task, otherwise the name of the tree.
        action_names: Names of the values of an action.
    """

    def __init__(self, tree: str, episode_length: int, **options: Any) -> None:
        super().__init__(tree, "rgb_array", physical_units=True, **options)
        self._max_episode_steps, self._steps = episode_length, 0  # LeRobot reads the first
        self.task_description = self.task.episodes.run.tree.task or tree
        self.action_names = self.task.action.space.names
        specs = self.task.observations.specs.items()
        empty = self._group({name: np.zeros(one.shape, one.dtype) for name, one in specs})
        self.observation_space = _space_of(empty)

    def reset(self, **options: Any) -> Any:
        """Start an episode; see `GymnasiumEnvironment.reset`."""
        self._steps = 0
        return super().reset(**options)

    def step(self, action: Any) -> Any:
        """Make one step; see `gymnasium.Env`."""
        space = self.task.action.space
        found = super().step(np.clip(action, space.low, space.high))
        self._steps += 1
        return *found[:3], self._steps >= self._max_episode_steps, found[4]

    def _observe(self) -> dict[str, Any]:
        return self._group(self.task.observe())

    def _group(self, found: Mapping[str, np.ndarray]) -> dict[str, Any]:
        """Return observations by LeRobot's keys: numbers in one array, images by camera."""
        numbers: dict[str, list[np.ndarray]] = {}
        images: dict[str, np.ndarray] = {}
        for name, spec in self.task.observations.specs.items():
            if len(spec.shape) == 1:
                key = STATE if spec.group == ROBOT else OBJECTS
                numbers.setdefault(key, []).append(found[name])
            else:
                images[name.removesuffix("_rgb")] = found[name]
        pixels = {"pixels": images} if images else {}
        return {key: np.concatenate(arrays) for key, arrays in numbers.items()} | pixels


def _space_of(value: Any) -> spaces.Space[Any]:
    """Return the space of an array, or of a dictionary of arrays."""
    if isinstance(value, dict):
        return spaces.Dict({key: _space_of(one) for key, one in value.items()})
    low, high = (0, 255) if value.dtype == np.uint8 else (-np.inf, np.inf)
    return spaces.Box(low, high, value.shape, value.dtype.type)


gymnasium.register(  # without wrappers, whose attributes LeRobot does not see
    ID, f"{__name__}:LeRobotEnvironment", order_enforce=False, disable_env_checker=True
)


@EnvConfig.register_subclass("bt_manip")
@dataclass
class BtManipEnv(EnvConfig):
    """Options of LeRobot's commands, ``--env.NAME=VALUE``.

    Attributes:
        task: The tree, as in ``bt-manip run``.
        fps: Steps per second.
        episode_length: Number of steps until truncation.
        options: Further options of the environment: ``{images: {cameras: [overview]}}``.
    """

    task: str | None = "pick_place"
    fps: int = 20
    episode_length: int = MAX_EPISODE_STEPS
    options: dict[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Declare the features, those of an environment with these options."""
        env: Any = gymnasium.make(ID, **self.gym_kwargs)
        found = {"action": env.action_space, **env.observation_space}
        for name, box in found.pop("pixels", {}).items():
            self.features[f"pixels/{name}"] = PolicyFeature(FeatureType.VISUAL, box.shape)
            self.features_map[f"pixels/{name}"] = f"observation.images.{name}"
        for key, box in found.items():
            kind, self.features_map[key] = FEATURES[key]
            self.features[key] = PolicyFeature(kind, box.shape)
        env.close()

    gym_id = ID

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """Arguments of `LeRobotEnvironment`."""
        own = {"tree": self.task, "episode_length": self.episode_length}
        return {**own, "step_time": 1.0 / self.fps, **self.options}
