"""Plugins: how they are found, chosen, checked, and kept from harming each other."""

from bt_manip.plugins.choice import Choice as Choice
from bt_manip.plugins.loading import load_plugins as load_plugins
from bt_manip.plugins.plugin import BUILTIN as BUILTIN
from bt_manip.plugins.plugin import Plugin as Plugin
from bt_manip.plugins.plugin import Plugins as Plugins
from bt_manip.plugins.plugin import PluginWarning as PluginWarning
