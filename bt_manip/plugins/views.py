"""Views of plugins, found without loading all that the plugins bring."""

import contextlib
import importlib.machinery
from collections.abc import Callable
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError
from bt_manip.plugins.entry_points import (
    FilePlugin,
    PluginSelection,
    in_folders,
    installed,
    names_of,
)

HOOK = "register_views"


def view_factories(choice: PluginSelection) -> dict[str, Callable[..., Any]]:
    """Return the factories of plugins' views by name; of duplicates, the first.

    Only modules in which the name of the hook stands are imported, and only this hook is called. A
    plugin for which that fails is left out without a word: whoever loads it is told.

    Args:
        choice: Blocked plugins, and folders with further plugins.
    """
    found: dict[str, Callable[..., Any]] = {}
    points = sorted(installed(), key=lambda p: (p.name, p.value))
    with contextlib.suppress(BtManipError):  # no such folder
        points += in_folders(choice.folders)
    for point in points:
        if _brings_views(point) and not choice.blocks(names_of(point)):  # reads its metadata
            views: dict[str, Callable[..., Any]] = {}
            with contextlib.suppress(Exception, SystemExit):
                getattr(point.load(), HOOK)(views.__setitem__)
                found = views | found
    return found


def _brings_views(point: EntryPoint) -> bool:
    path = Path(point.value) if isinstance(point, FilePlugin) else source_of(point.module)
    try:
        return path is not None and HOOK.encode() in path.read_bytes()
    except OSError:
        return False


def source_of(module: str) -> Path | None:
    """Return a module's file without importing its packages."""
    places: list[str] | None = None
    parts = module.split(".")
    for i in range(len(parts)):
        spec = importlib.machinery.PathFinder.find_spec(".".join(parts[: i + 1]), places)
        if spec is None:
            return None
        places = list(spec.submodule_search_locations or ())
    return Path(spec.origin) if spec is not None and spec.origin else None
