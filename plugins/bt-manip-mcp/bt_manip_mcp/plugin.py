"""What the package brings; everything expensive is imported when it is needed."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookimpl


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip mcp``."""
    register("mcp", "bt_manip_mcp.commands:mcp")


@hookimpl
def register_recorders(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the picture of the end of a run."""
    from bt_manip_mcp.picture import PictureRecorder

    register("picture", PictureRecorder)
