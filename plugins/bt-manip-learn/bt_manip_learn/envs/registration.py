"""Registration of trees with Gymnasium."""

import time

import gymnasium

from bt_manip.exceptions import BtManipError
from bt_manip.plugins import load_plugins
from bt_manip.registry import Parts
from bt_manip.runner import find_tree, load_source

NAMESPACE = "bt_manip"

MAX_EPISODE_STEPS = 1200
"""Default number of steps until truncation: one minute at 20 Hz."""


def environment_id(tree: str) -> str:
    """Return the id of the environment of a registered tree: ``bt_manip/PickPlace-v0``."""
    words = tree.replace("-", "_").split("_")
    return f"{NAMESPACE}/{''.join(word[:1].upper() + word[1:] for word in words)}-v0"


def register_environments() -> None:
    """Register all trees without required arguments with Gymnasium."""
    parts = load_plugins(warn=lambda message: None).parts
    for tree in parts.trees:
        if environment_id(tree) not in gymnasium.registry and _needs_nothing(tree, parts):
            gymnasium.register(
                environment_id(tree),
                entry_point="bt_manip_learn.envs.gymnasium_env:GymnasiumEnvironment",
                vector_entry_point="bt_manip_learn.envs.vector_env:BatchEnvironment",
                max_episode_steps=MAX_EPISODE_STEPS,
                kwargs={"tree": tree},
            )


def _needs_nothing(tree: str, parts: Parts) -> bool:
    """Return whether a tree declares a goal and has defaults for all settings."""
    try:
        source = find_tree(tree, {tree: parts.trees.get(tree)})
        return bool(load_source(source, parts, {}, time.monotonic).goal)
    except BtManipError:
        return False


register_environments()
