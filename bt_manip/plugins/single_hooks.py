"""Hooks that the command line calls alone, without loading all that the plugins bring."""

import contextlib
import importlib.machinery
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from bt_manip.exceptions import BtManipError
from bt_manip.plugins.entry_points import (
    FilePlugin,
    PluginPoint,
    PluginSelection,
    in_folders,
    installed,
    names_of,
)

T = TypeVar("T")


def call_single_hook(
    hook: str, choice: PluginSelection, item: Callable[..., tuple[str, T]]
) -> dict[str, T]:
    """Call one hook of each plugin, and return what it registers; of duplicates, the first.

    Only modules in which the name of the hook stands are imported, and only this hook is called. A
    plugin for which that fails is left out without a warning: loading it gives one.

    Args:
        hook: Name of the hook.
        choice: Blocked plugins, and folders with further plugins.
        item: Returns a key and a value for the entry point of the plugin, and the arguments with
            which the plugin calls ``register``.
    """
    found: dict[str, T] = {}
    points = sorted(installed(), key=lambda p: (p.name, p.value))
    with contextlib.suppress(BtManipError):  # no such folder
        points += in_folders(choice.folders)
    for point in points:
        if choice.blocked and choice.blocks(names_of(point)):
            continue
        if _mentions(point, hook):
            with contextlib.suppress(Exception, SystemExit):
                found = _registered(point, hook, item) | found
    return found


def factories_of(hook: str, choice: PluginSelection) -> dict[str, Callable[..., Any]]:
    """Return the factories that plugins register by one hook, by name."""
    return call_single_hook(hook, choice, lambda _, name, factory: (name, factory))


def _registered(point: PluginPoint, hook: str, item: Callable[..., tuple[str, T]]) -> dict[str, T]:
    registered: dict[str, T] = {}

    def register(*arguments: Any, **named: Any) -> None:
        key, value = item(point, *arguments, **named)
        registered.setdefault(key, value)

    getattr(point.load(), hook)(register)
    return registered


def _mentions(point: PluginPoint, hook: str) -> bool:
    path = Path(point.value) if isinstance(point, FilePlugin) else source_of(point.module)
    try:
        return path is not None and hook.encode() in path.read_bytes()
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
