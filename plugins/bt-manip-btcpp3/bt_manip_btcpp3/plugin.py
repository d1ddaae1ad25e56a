"""Hooks of this package."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookimpl


@hookimpl
def register_dialects(register: Callable[[Any], None]) -> None:
    """Register the dialect of BehaviorTree.CPP 3."""
    from bt_manip_btcpp3.dialect import BTCPP3

    register(BTCPP3)
