"""Export of demonstrations as a Minari dataset."""

from pathlib import Path
from typing import Any

import numpy as np

from bt_manip.exceptions import BtManipError

from .export_robomimic import action_space, env_args
from .store import ALL, DemonstrationStore


def write_minari(
    store: DemonstrationStore, folder: Path, actions: str, observations: str = ALL
) -> int:
    """Write demonstrations as a Minari dataset, called as the folder: ``pick_place-v0``.

    Observations are a dictionary as in the environment, which `recover_environment` makes again;
    actions are scaled to [-1, 1] as it takes them.

    Args:
        store: The demonstrations.
        folder: The folder to create; ``minari.load_dataset`` looks for it in the folder
            ``MINARI_DATASETS_PATH``.
        actions: Kind of the actions to write.
        observations: Group of observations, see `DemonstrationStore.observed`.

    Returns:
        Number of demonstrations.

    Raises:
        BtManipError: If there are no demonstrations, the kind of actions is unknown, the folder
            exists, its name is no name of a dataset, or Minari is not installed.
    """
    store.check_actions(actions)
    try:
        import minari
        from gymnasium.envs.registration import EnvSpec
        from gymnasium.spaces import Box, Dict
        from minari.data_collector.episode_buffer import EpisodeBuffer
        from minari.dataset.minari_dataset import parse_dataset_id
        from minari.dataset.minari_storage import MinariStorage
    except ImportError as error:
        raise BtManipError("Minari is missing: pip install 'bt-manip-learn[minari]'") from error
    try:
        parse_dataset_id(folder.name)
    except ValueError as error:
        raise BtManipError(f"'{folder.name}' is no name such as pick_place-v0: {error}") from error
    if folder.exists():
        raise BtManipError(f"'{folder}' exists: choose another folder, which Minari makes")
    space = action_space(store.manifest["actions"][actions])
    storage: Any = None
    n = 0
    for one in store:
        observed = store.observed(one, observations)
        if storage is None:
            folder.mkdir(parents=True)
            storage = MinariStorage.new(
                folder.absolute() / "data",  # relative ones are joined twice
                Dict({name: _box(array) for name, array in observed.items()}),
                Box(-1.0, 1.0, space.shape, np.float32),
                EnvSpec(
                    f"bt_manip/{store.manifest['tree']}",
                    "bt_manip_learn.envs.gymnasium_env:GymnasiumEnvironment",
                    kwargs=env_args(store.manifest, actions)["env_kwargs"],
                ),
                jpeg_encoding=False,  # lossless
            )
            about = {"dataset_id": folder.name, "minari_version": minari.__version__}
            storage.update_metadata(about)
        buffer = EpisodeBuffer(
            seed=store.manifest["seed"],
            options={"episode": one.episode},
            observations=dict(observed),
            actions=space.normalized(one.actions[actions]),
            rewards=one.rewards.tolist(),
            terminations=(one.dones & one.success).tolist(),
            truncations=(one.dones & (not one.success)).tolist(),
        )
        storage.update_episodes([buffer])
        n += 1
    if not n:
        raise BtManipError(f"'{store.folder}' has no demonstrations to export")
    return n


def _box(array: np.ndarray) -> Any:
    """Return the space of the rows of an array, bounded for images in colour."""
    from gymnasium.spaces import Box

    low, high = (0, 255) if array.dtype == np.uint8 else (-np.inf, np.inf)
    return Box(low, high, array.shape[1:], array.dtype.type)
