"""The hook that this package declares."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookspec


@hookspec("action kind")
def register_actions(register: Callable[[str, Callable[[Any], Any]], None]) -> None:
    """Register kinds of actions, by which agents act in episodes and environments.

    Args:
        register: ``register(name, factory)``, where ``factory(episodes)`` returns a new
            `bt_manip_learn.agents.ActionKind` for a `bt_manip_learn.agents.Episodes`.
    """
