"""Hooks of this package."""

from collections.abc import Callable

from bt_manip import hookimpl


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip robot``, and ``bt-manip robot measure``."""
    register("robot", "bt_manip_setup.commands:robot")
    register("measure", "bt_manip_setup.finger_travel.command:measure", group="robot")
