"""Export of demonstrations as one HDF5 file for robomimic."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.record import whole_file, writing

from .store import ALL, DemonstrationStore, put_array

if TYPE_CHECKING:
    from bt_manip_learn.agents import ActionSpace

GYM_TYPE = 2
"""robomimic's type number of Gym environments."""

VALID = 0.1
"""Share of demonstrations in ``mask/valid``."""


def write_robomimic(
    store: DemonstrationStore, path: Path, actions: str, observations: str = ALL
) -> int:
    """Write demonstrations in robomimic's layout.

    The actions are scaled to [-1, 1], as the environment takes them and robomimic's networks output
    them. In addition to robomimic's data, each demonstration has all kinds of actions in physical
    units as ``action_dict/KIND``, the ``statuses`` of the nodes, and the running leaf as ``leaf``,
    an index into ``leaves``; the file has the ``manifest``.

    Args:
        store: The demonstrations.
        path: The file; an existing one is replaced.
        actions: Kind of the actions to write as ``actions``.
        observations: Group of observations, see `DemonstrationStore.observed`.

    Returns:
        Number of demonstrations.

    Raises:
        BtManipError: If there are no demonstrations, or the kind of actions is unknown.
    """
    import h5py

    demos: list[str] = []
    leaves: dict[str, int] = {}
    total = 0
    store.check_actions(actions)
    space = action_space(store.manifest["actions"][actions])
    with writing(path, "export"), whole_file(path) as out, h5py.File(out, "w") as file:
        data = file.create_group("data")
        for one in store:
            demos.append(f"demo_{len(demos)}")
            demo = data.create_group(demos[-1])
            demo.attrs.update(num_samples=len(one), episode=one.episode, success=one.success)
            for name, array in store.observed(one, observations).items():
                put_array(demo, f"obs/{name}", array[:-1])
                put_array(demo, f"next_obs/{name}", array[1:])
            for name, array in one.actions.items():
                put_array(demo, f"action_dict/{name}", array)
            leaf = [leaves.setdefault(path, len(leaves)) for path in one.leaves]
            arrays = {
                "actions": space.normalized(one.actions[actions]),
                "states": one.states[:-1],
                "rewards": one.rewards,
                "dones": one.dones.astype(np.int64),
                "leaf": np.array(leaf),
                "statuses": one.statuses,
            }
            for name, array in arrays.items():
                put_array(demo, name, array)
            total += len(one)
        if not demos:
            raise BtManipError(f"'{store.folder}' has no demonstrations to export")
        data.attrs.update(total=total, env_args=json.dumps(env_args(store.manifest, actions)))
        text = h5py.string_dtype()
        file.create_dataset("leaves", data=[*leaves], dtype=text)
        file.create_dataset("manifest", data=json.dumps(store.manifest), dtype=text)
        for name, names in split(demos).items():
            file.create_dataset(f"mask/{name}", data=np.array(names, dtype="S"))
    return len(demos)


def action_space(described: Mapping[str, Any]) -> "ActionSpace":
    """Return the space of a kind of actions, as the manifest describes it."""
    from bt_manip_learn.agents import ActionSpace

    low, high = (np.array(described[key], dtype=np.float32) for key in ("low", "high"))
    return ActionSpace(low, high, tuple(described["names"]), tuple(described["units"]))


def env_args(manifest: Mapping[str, Any], actions: str) -> dict[str, Any]:
    """Return robomimic's description of the environment: `GymnasiumEnvironment(**env_kwargs)`."""
    kwargs = {key: manifest[key] for key in ("tree", "scene", "settings", "images")}
    kwargs |= manifest["request"]  # robot, controller and planner
    kwargs |= {"vary": manifest["varied"], "tick": manifest["tick_s"], "action": actions}
    return {"env_name": manifest["tree"], "type": GYM_TYPE, "env_kwargs": kwargs}


def split(demos: list[str]) -> dict[str, list[str]]:
    """Split demonstrations into a training and a validation set, deterministically."""
    n = max(round(VALID * len(demos)), len(demos) > 1)
    chosen = np.random.default_rng(0).permutation(len(demos))[:n]
    valid = {demos[i] for i in chosen}
    return {
        "train": [name for name in demos if name not in valid],
        "valid": [name for name in demos if name in valid],
    }
