"""Loading plugins from modules without entry points, for tests."""

from importlib.metadata import EntryPoint
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_manip.plugins import Plugins


class _Given(EntryPoint):
    """Entry point of a plugin that is imported already."""

    def __init__(self, plugin: object) -> None:
        name = str(getattr(plugin, "__name__", type(plugin).__name__))
        super().__init__(name, name, "bt_manip")
        vars(self)["plugin"] = plugin  # entry points are immutable otherwise

    def load(self) -> object:
        return vars(self)["plugin"]


def load_given_plugins(*plugins: object) -> "Plugins":
    """Load the given plugins and the built-in one, without installed ones.

    Args:
        *plugins: Modules or objects with hooks.

    Raises:
        AssertionError: When one is broken, with the reason.
    """
    from bt_manip.plugins import Choice, load_plugins

    points = [_Given(p) for p in plugins]
    problems: list[str] = []
    loaded = load_plugins(entry_points=points, warn=problems.append, choice=Choice())
    if problems:
        raise AssertionError("\n".join(problems))
    return loaded
