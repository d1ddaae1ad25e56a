"""Behaviour trees for manipulation: tasks, robot cells and plugins.

Importing this costs nothing: each name is imported when it is first used.
"""

import importlib
import re
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_manip.packages import MovedModules, name_moved_modules
from bt_manip.registry import set_loader

if TYPE_CHECKING:
    from bt_manip.bt import load_tree as load_tree
    from bt_manip.hookspecs import hookimpl as hookimpl
    from bt_manip.plugins import build_station as build_station
    from bt_manip.plugins import hookspec as hookspec
    from bt_manip.plugins import load_plugins as load_plugins
    from bt_manip.version import __version__ as __version__

# dm_control tries GLFW if MUJOCO_GL is unset, and does without where there is no display.
warnings.filterwarnings(
    "ignore",
    r".*(X11: (The DISPLAY environment variable|Failed to open)|GLFW library is not initialized)",
)


def lazy_exports(package: str) -> Callable[[str], Any]:
    """Make a package's ``__getattr__`` (PEP 562), for exports that are expensive to import.

    It exports what type checkers see: the imports ``from MODULE import NAME as NAME`` under ``if
    TYPE_CHECKING`` in its source. Names that have moved into another package raise an ImportError
    that says so.

    Args:
        package: Full name of the package.
    """
    source = Path(str(sys.modules[package].__file__)).read_text(encoding="utf-8")
    lines = re.finditer(r"^    from (\S+) import \(?\s*(\w+) as \2\b", source, re.MULTILINE)
    modules = {line[2]: line[1] for line in lines}

    def get(name: str) -> Any:
        if name not in modules:
            MovedModules.find_spec(f"{package}.{name}")
            raise AttributeError(f"module '{package}' has no attribute {name!r}")
        return getattr(importlib.import_module(modules[name], package), name)

    return get


__getattr__ = lazy_exports(__name__)


def _installed_parts() -> Any:
    from bt_manip.plugins import load_plugins

    return load_plugins().parts


set_loader(_installed_parts)
name_moved_modules()
