"""Behaviour trees for manipulation: tasks, robot cells and plugins."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bt_manip.hookspecs import hookimpl as hookimpl


def __getattr__(name: str) -> Any:
    """Hand on `hookimpl` when it is first asked for, so that the package itself costs nothing."""
    if name == "hookimpl":
        from bt_manip.hookspecs import hookimpl

        return hookimpl
    raise AttributeError(f"module 'bt_manip' has no attribute {name!r}")
