"""Plugins: how they are found, chosen, checked, and kept from harming each other."""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from bt_manip.plugins.choice import Choice as Choice
    from bt_manip.plugins.loading import load_plugins as load_plugins
    from bt_manip.plugins.plugin import BUILTIN as BUILTIN
    from bt_manip.plugins.plugin import Plugin as Plugin
    from bt_manip.plugins.plugin import Plugins as Plugins
    from bt_manip.plugins.plugin import PluginWarning as PluginWarning

_PLACES = {
    "Choice": "choice",
    "load_plugins": "loading",
    "BUILTIN": "plugin",
    "Plugin": "plugin",
    "Plugins": "plugin",
    "PluginWarning": "plugin",
}


def __getattr__(name: str) -> Any:
    """Import what is asked for then: ``--help`` needs no more than the names of plugins."""
    if name not in _PLACES:
        raise AttributeError(f"module 'bt_manip.plugins' has no attribute {name!r}")
    return getattr(importlib.import_module(f"bt_manip.plugins.{_PLACES[name]}"), name)
