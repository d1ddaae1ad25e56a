"""Entry points of plugins: installed packages, and single files in a folder."""

import importlib.metadata
import importlib.util
import re
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from bt_manip.exceptions import BtManipError

PREFIX = "bt-manip-"
"""Conventional prefix of the names of plugin packages."""


class EntryPoint(Protocol):
    """Interface of `importlib.metadata.EntryPoint`."""

    @property
    def name(self) -> str:
        """Name of the plugin."""

    @property
    def value(self) -> str:
        """Its location, as ``package.module`` or a file."""

    @property
    def module(self) -> str:
        """Name of its module."""

    @property
    def dist(self) -> Any:
        """The distribution that declares it, with `name` and `version`, or None."""

    def load(self) -> Any:
        """Import it."""


@dataclass(frozen=True)
class FilePlugin:
    """Single-file plugin, loaded by its path and not through ``sys.path``."""

    path: Path

    dist: Any = None

    @property
    def name(self) -> str:
        """The file's name."""
        return self.path.stem

    @property
    def value(self) -> str:
        """The file."""
        return str(self.path)

    @property
    def module(self) -> str:
        """Module name that cannot clash with modules on ``sys.path``."""
        return "_bt_manip_plugin_" + re.sub(r"\W", "_", self.name)

    def load(self) -> Any:
        """Import the file; a failure leaves no module in ``sys.modules``."""
        known = sys.modules.get(self.module)
        if known is not None and known.__file__ == self.value:
            return known
        spec = importlib.util.spec_from_file_location(self.module, self.path)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[self.module] = module  # where dataclasses and pickles look for it
        try:
            spec.loader.exec_module(module)
        except BaseException:
            del sys.modules[self.module]
            raise
        return module


def installed() -> tuple[EntryPoint, ...]:
    """Return the entry points of installed plugins."""
    from bt_manip import hookspecs  # imports pluggy, which names do not need

    return tuple(importlib.metadata.entry_points(group=hookspecs.GROUP))


def in_folders(folders: Iterable[Path]) -> tuple[EntryPoint, ...]:
    """Return the single-file plugins: each ``*.py`` whose name does not begin with ``_``.

    Raises:
        BtManipError: When there is no such folder.
    """
    found: list[EntryPoint] = []
    for folder in folders:
        if not folder.is_dir():
            raise BtManipError(f"no folder '{folder}' to take plugins from")
        files = sorted(folder.resolve().glob("*.py"))
        found += [FilePlugin(p) for p in files if not p.is_dir() and not p.name.startswith("_")]
    return tuple(found)


def names_of(point: EntryPoint) -> set[str]:
    """Return the names that block a plugin: its name and its package's, with and without prefix."""
    return block_names(point.name, "" if point.dist is None else str(point.dist.name))


def block_names(name: str, package: str) -> set[str]:
    """Return the names that block a plugin; the package name may be empty."""
    if not package:
        return {name}
    plain = re.sub(r"[-_.]+", "-", package).lower()
    return {name, package, plain, plain.removeprefix(PREFIX)}
