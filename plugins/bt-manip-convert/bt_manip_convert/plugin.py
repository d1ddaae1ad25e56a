"""Hooks of this package."""

from collections.abc import Callable
from typing import Any

from bt_manip import hookimpl


@hookimpl
def register_conversions(register: Callable[[str, Callable[..., Any]], None]) -> None:
    """Register the conversion of trees to Python."""
    from bt_manip_convert.python_source import to_python

    register("python", to_python)
