"""Hooks of this package."""

from collections.abc import Callable

from bt_manip import hookimpl


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip robot``."""
    register("robot", "bt_manip_setup.commands:robot")
