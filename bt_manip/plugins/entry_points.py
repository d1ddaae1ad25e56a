"""Entry points of plugins: installed packages, and single files in a folder."""

import importlib.util
import os
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.metadata import Distribution, EntryPoint, distributions
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError

GROUP = "bt_manip"
"""Entry-point group of plugins."""

COMMAND_GROUP = "bt_manip.commands"
"""Deprecated entry-point group: the name of each command, and ``module:function``."""

PREFIX = "bt-manip-"
"""Conventional prefix of the names of plugin packages."""

BLOCK_VARIABLE = "BT_MANIP_BLOCK"
"""Environment variable: names of blocked plugins, separated by commas or spaces."""

FOLDERS_VARIABLE = "BT_MANIP_PLUGINS_DIR"
"""Environment variable: folders of single-file plugins, separated as in PATH."""


@dataclass(frozen=True)
class PluginSelection:
    """Selection of plugins besides the built-in one.

    Attributes:
        blocked: Names of plugins or packages that are not loaded.
        folders: Folders in which each ``*.py`` is a plugin.
    """

    blocked: frozenset[str] = frozenset()
    folders: tuple[Path, ...] = ()

    @classmethod
    def from_environment(cls) -> "PluginSelection":
        """Read the selection from environment variables."""
        names = re.split(r"[\s,]+", os.environ.get(BLOCK_VARIABLE, ""))
        folders = os.environ.get(FOLDERS_VARIABLE, "").split(os.pathsep)
        return cls().extended(names, map(Path, filter(None, folders)))

    def extended(
        self, blocked: Iterable[str] = (), folders: Iterable[Path] = ()
    ) -> "PluginSelection":
        """Return a selection with further blocked names and folders."""
        more = tuple(folder for folder in dict.fromkeys(folders) if folder not in self.folders)
        return PluginSelection(
            self.blocked | {name for name in blocked if name}, self.folders + more
        )

    def blocks(self, names: Iterable[str]) -> bool:
        """Return whether any of these names is blocked."""
        return not self.blocked.isdisjoint(names)


class FilePlugin(EntryPoint):
    """Single-file plugin, loaded by its path, not through ``sys.path``.

    Args:
        path: The file; its stem is the name of the plugin.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path.stem, str(path), GROUP)

    @property
    def module(self) -> str:
        """Module name that cannot clash with modules on ``sys.path``."""
        return "_bt_manip_plugin_" + re.sub(r"\W", "_", self.name)

    def load(self) -> Any:
        """Import the file; after a failure there is no module in ``sys.modules``."""
        known = sys.modules.get(self.module)
        if known is not None and known.__file__ == self.value:
            return known
        spec = importlib.util.spec_from_file_location(self.module, self.value)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[self.module] = module  # required by dataclasses and pickle
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[self.module]
            raise
        return module


def installed(group: str = GROUP) -> tuple[EntryPoint, ...]:
    """Return the entry points of installed packages in a group.

    `importlib.metadata.entry_points` parses the entry points of all packages, which takes five
    times longer than to read them.

    Args:
        group: ``bt_manip``, or a group whose name begins with it.
    """
    found: dict[str, Distribution] = {}
    for dist in distributions():
        if f"[{GROUP}" in (dist.read_text("entry_points.txt") or ""):
            found.setdefault(_normalized(_field(dist, "Name")), dist)  # the first one is imported
    return tuple(p for dist in found.values() for p in dist.entry_points.select(group=group))


def label_of(point: EntryPoint) -> str:
    """Return the name and version of a plugin's package, or the name of its file."""
    if point.dist is None:
        return Path(point.value).name
    return f"{_field(point.dist, 'Name')} {_field(point.dist, 'Version')}"


def _field(dist: Distribution, name: str) -> str:
    """Return a field of a package's metadata, which `email` would parse as a whole."""
    text = dist.read_text("METADATA") or dist.read_text("PKG-INFO") or ""
    match = re.search(rf"^{name}: *(.*)$", text, re.MULTILINE)
    return match[1].strip() if match else ""


def in_folders(folders: Iterable[Path]) -> tuple[EntryPoint, ...]:
    """Return the single-file plugins: each ``*.py`` whose name does not begin with ``_``.

    Raises:
        BtManipError: If there is no such folder.
    """
    found: list[EntryPoint] = []
    for folder in folders:
        if not folder.is_dir():
            raise BtManipError(f"no folder '{folder}' to take plugins from")
        files = sorted(folder.resolve().glob("*.py"))
        found += [FilePlugin(p) for p in files if not p.is_dir() and not p.name.startswith("_")]
    return tuple(found)


def names_of(point: EntryPoint) -> set[str]:
    """Return the names that block a plugin: its own and its package's, with and without prefix."""
    return block_names(point.name, "" if point.dist is None else str(point.dist.name))


def block_names(name: str, package: str) -> set[str]:
    """Return the names that block a plugin; the package name may be empty."""
    if not package:
        return {name}
    plain = _normalized(package)
    return {name, package, plain, plain.removeprefix(PREFIX)}


def _normalized(package: str) -> str:
    return re.sub(r"[-_.]+", "-", package).lower()
