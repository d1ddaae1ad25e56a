"""Behaviour trees for manipulation: tasks, robot cells and plugins.

Importing this costs nothing: each name is imported when it is first used.
"""

import warnings
from typing import TYPE_CHECKING, Any

from bt_manip.installed import set_loader
from bt_manip.lazy_exports import lazy_exports

if TYPE_CHECKING:
    from bt_manip.bt import load_tree as load_tree
    from bt_manip.hookspecs import hookimpl as hookimpl
    from bt_manip.plugins import build_station as build_station
    from bt_manip.plugins import load_plugins as load_plugins
    from bt_manip.version import __version__ as __version__

# dm_control tries GLFW if MUJOCO_GL is unset, and does without where there is no display.
warnings.filterwarnings(
    "ignore",
    r".*(X11: (The DISPLAY environment variable|Failed to open)|GLFW library is not initialized)",
)

__getattr__ = lazy_exports(__name__, __file__)


def _installed_parts() -> Any:
    from bt_manip.plugins import load_plugins

    return load_plugins().parts


set_loader(_installed_parts)
