"""robomimic environment of a tree, for rollouts; requires robomimic."""

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from robomimic.envs.env_base import EnvBase, EnvType
from robomimic.utils import obs_utils

from bt_manip.exceptions import BtManipError
from bt_manip.record import reading

from .gymnasium_env import GymnasiumEnvironment

IGNORED = ("render", "render_offscreen", "use_image_obs", "postprocess_visual_obs")
"""Options of robomimic's environments without effect; ``images`` replaces them."""


class RobomimicEnvironment(EnvBase):
    """The environment of exported demonstrations, with the methods for robomimic's rollouts.

    It replaces robomimic's own class for ``env_args["type"]``, which imports ``gym``, the
    predecessor of Gymnasium. Episodes have a random seed until `seed` is called.

    Args:
        env_name: Name in results.
        **options: Options of `GymnasiumEnvironment`, as in ``env_args["env_kwargs"]``.

    Attributes:
        env: The environment.

    Raises:
        BtManipError: If an option is invalid.
    """

    def __init__(self, env_name: str, **options: Any) -> None:
        self._name = env_name
        self._options = {key: value for key, value in options.items() if key not in IGNORED}
        self.env = GymnasiumEnvironment(**self._options)
        self._next_seed: int | None = None
        self._observation: dict[str, np.ndarray] = {}
        self._reward, self._done, self._success = 0.0, False, False

    @classmethod
    def from_file(cls, path: Path | str) -> "RobomimicEnvironment":
        """Return the environment of an exported file of demonstrations.

        Raises:
            BtManipError: If the file is not such an export.
        """
        with reading(Path(path), "export for robomimic"), h5py.File(path) as file:
            args = json.loads(file["data"].attrs["env_args"])
            name, options = args["env_name"], args["env_kwargs"]
        return cls(name, **options)

    @classmethod
    def create_for_data_processing(
        cls, env_name: str, *cameras: Any, **options: Any
    ) -> "RobomimicEnvironment":
        """Return an environment whose options determine cameras and reward."""
        ignored = ("camera_names", "camera_height", "camera_width", "reward_shaping")
        return cls(env_name, **{k: v for k, v in options.items() if k not in ignored})

    def seed(self, seed: int) -> None:
        """Set the seed of the next episode."""
        self._next_seed = seed

    def reset(self) -> dict[str, np.ndarray]:
        """Start the next episode."""
        self._observation, _ = self.env.reset(seed=self._next_seed)
        self._next_seed, self._done, self._success = None, False, False
        return self.get_observation()

    def step(self, action: Any) -> tuple[dict[str, np.ndarray], float, bool, dict[str, Any]]:
        """Make one step."""
        self._observation, self._reward, self._done, _, info = self.env.step(action)
        self._success = bool(info["is_success"])
        return self.get_observation(), self._reward, self._done, info

    def get_observation(self, obs: Any = None) -> dict[str, np.ndarray]:
        """Return the present observations, with images in the form of robomimic's networks."""
        found = dict(self._observation if obs is None else obs)
        for name in found:
            if obs_utils.OBS_KEYS_TO_MODALITIES and obs_utils.key_is_obs_modality(name, "rgb"):
                found[name] = obs_utils.process_obs(found[name], obs_key=name)
        return found

    def get_state(self) -> dict[str, Any]:
        """Return the state of the episode, for `reset_to`."""
        return {"states": self.env.get_state()}

    def reset_to(self, state: dict[str, Any]) -> dict[str, np.ndarray]:
        """Continue from a state of `get_state`.

        Raises:
            BtManipError: If it is an array, as in files, which have only the physics.
        """
        if not isinstance(state["states"], dict):
            raise BtManipError("an episode continues from a state of get_state(), not from arrays")
        self._observation, _ = self.env.reset(options={"state": state["states"]})
        self._done = self._success = False
        return self.get_observation()

    def render(self, mode: str = "human", **options: Any) -> Any:
        """Return an image, if ``render_mode`` is ``"rgb_array"``."""
        return self.env.render()

    def get_reward(self) -> float:
        """Return the reward of the last step."""
        return self._reward

    def get_goal(self) -> Any:
        """Refuse: robomimic's goals are observations, which a tree does not have."""
        raise NotImplementedError

    def set_goal(self, **goal: Any) -> None:
        """Refuse; see `get_goal`."""
        raise NotImplementedError

    def is_done(self) -> bool:
        """Return whether the episode has ended."""
        return self._done

    def is_success(self) -> dict[str, bool]:
        """Return whether the goal of the tree holds."""
        return {"task": self._success}

    @property
    def action_dimension(self) -> int:
        """Dimension of an action."""
        return int(self.env.action_space.shape[0])  # type: ignore[index]

    @property
    def name(self) -> str:
        """Name in results."""
        return self._name

    @property
    def type(self) -> int:
        """Type number of Gym environments in robomimic."""
        return int(EnvType.GYM_TYPE)

    @property
    def rollout_exceptions(self) -> tuple[Any, ...]:
        """Exceptions that end a rollout: none; diverging physics end the episode."""
        return ()

    def serialize(self) -> dict[str, Any]:
        """Return the arguments of the environment, as in ``env_args`` of a file."""
        return {"env_name": self._name, "type": self.type, "env_kwargs": self._options}
