"""Plugins by their modules, without an entry point: for tests of a plugin."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bt_manip.plugins import Plugins


@dataclass(frozen=True)
class _Given:
    """Looks like an entry point."""

    name: str
    value: str
    module: str
    plugin: object
    dist: Any = None

    def load(self) -> object:
        return self.plugin


def load_given_plugins(*plugins: object) -> "Plugins":
    """Load some plugins beside the built-in one, and no installed ones.

    Args:
        *plugins: Modules or objects with hooks.

    Raises:
        AssertionError: When one is broken; it says why.
    """
    from bt_manip.plugins import Choice, load_plugins

    points = [_Given(_name(p), _name(p), _name(p), p) for p in plugins]
    problems: list[str] = []
    loaded = load_plugins(entry_points=points, warn=problems.append, choice=Choice())
    if problems:
        raise AssertionError("\n".join(problems))
    return loaded


def _name(plugin: object) -> str:
    return str(getattr(plugin, "__name__", type(plugin).__name__))
