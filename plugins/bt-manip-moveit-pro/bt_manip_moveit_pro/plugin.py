"""Hooks of this package."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookimpl


@hookimpl
def register_dialects(register: Callable[[Any], None]) -> None:
    """Register the dialect of MoveIt Pro."""
    from bt_manip_moveit_pro.dialect import MOVEIT_PRO

    register(MOVEIT_PRO)
