"""Discovery, selection, checks and isolation of plugins.

Names are imported on first use, since ``--help`` needs only the names of plugins.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from bt_manip.plugins.declared_hooks import hookspec as hookspec
    from bt_manip.plugins.entry_points import COMMAND_GROUP as COMMAND_GROUP
    from bt_manip.plugins.entry_points import PREFIX as PREFIX
    from bt_manip.plugins.entry_points import PluginPoint as PluginPoint
    from bt_manip.plugins.entry_points import PluginSelection as PluginSelection
    from bt_manip.plugins.entry_points import installed as installed
    from bt_manip.plugins.entry_points import label_of as label_of
    from bt_manip.plugins.entry_points import names_of as names_of
    from bt_manip.plugins.loading import load_plugins as load_plugins
    from bt_manip.plugins.plugin import BUILTIN as BUILTIN
    from bt_manip.plugins.plugin import Plugin as Plugin
    from bt_manip.plugins.plugin import Plugins as Plugins
    from bt_manip.plugins.plugin import PluginWarning as PluginWarning
    from bt_manip.plugins.single_hooks import call_single_hook as call_single_hook
    from bt_manip.plugins.single_hooks import factories_of as factories_of
    from bt_manip.plugins.single_hooks import source_of as source_of
    from bt_manip.plugins.stations import build_station as build_station
    from bt_manip.plugins.watching import guarded as guarded
    from bt_manip.plugins.watching import plugin_observers as plugin_observers

__getattr__ = lazy_exports(__name__)
