"""The ids of all trees in Gymnasium's registry, where that is installed."""

import importlib.util

NAMESPACE = "bt_manip"

MAX_EPISODE_STEPS = 1200
"""Steps after which an episode is truncated: a minute at 20 Hz; ``make`` can change it."""


def environment_id(tree: str) -> str:
    """Return the id of the environment of a registered tree: ``bt_manip/PickPlace-v0``."""
    words = tree.replace("-", "_").split("_")
    return f"{NAMESPACE}/{''.join(word[:1].upper() + word[1:] for word in words)}-v0"


def register_environments() -> None:
    """Register the environments of all trees of all installed plugins with Gymnasium."""
    import gymnasium

    from bt_manip.plugins import load_plugins

    for tree in load_plugins(warn=lambda message: None).parts.trees:
        if environment_id(tree) not in gymnasium.registry:
            gymnasium.register(
                environment_id(tree),
                entry_point="bt_manip.envs.gymnasium_env:GymnasiumEnvironment",
                max_episode_steps=MAX_EPISODE_STEPS,
                kwargs={"tree": tree},
            )


if importlib.util.find_spec("gymnasium") is not None:
    register_environments()
