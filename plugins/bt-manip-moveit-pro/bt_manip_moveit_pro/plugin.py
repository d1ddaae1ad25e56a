"""Hooks of this package."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from bt_manip import hookimpl

ROBOTS = Path(__file__).parent / "robots"


@hookimpl
def register_commands(register: Callable[..., None]) -> None:
    """Register ``bt-manip objectives``."""
    register("objectives", "bt_manip_moveit_pro.command:objectives")


@hookimpl
def register_robots(register: Callable[[Any], None]) -> None:
    """Register the Gen3; its models are fetched on first use."""
    from bt_manip.robots import read_description

    for path in sorted(ROBOTS.glob("*.toml")):
        register(read_description(path))


@hookimpl
def register_dialects(register: Callable[[Any], None]) -> None:
    """Register the dialect of MoveIt Pro."""
    from bt_manip_moveit_pro.dialect import MOVEIT_PRO

    register(MOVEIT_PRO)
