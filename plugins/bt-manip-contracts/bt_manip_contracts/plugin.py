"""Hooks of this package."""

from collections.abc import Callable

from bt_manip import hookimpl


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip new``."""
    register("new", "bt_manip_contracts.commands:new")
