"""Hooks of this package."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookimpl


@hookimpl
def register_behaviours(register: Callable[..., None]) -> None:
    """Register the control nodes and decorators."""
    from bt_manip_nav2.dialect import NODES

    for cls in NODES:
        register(cls)


@hookimpl
def register_dialects(register: Callable[[Any], None]) -> None:
    """Register the dialect, which knows what Nav2's navigator writes."""
    from bt_manip_nav2.dialect import NAV2

    register(NAV2)
