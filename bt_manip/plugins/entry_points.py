"""Where plugins are: in installed packages, or as single files in a folder."""

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
"""What the names of packages with plugins begin with."""


class EntryPoint(Protocol):
    """What is read of an entry point; `importlib.metadata.EntryPoint` is one."""

    @property
    def name(self) -> str:
        """Name of the plugin."""

    @property
    def value(self) -> str:
        """Where it is, as ``package.module``, or a file."""

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
    """A plugin that is one file; it is found by its place, and never through ``sys.path``."""

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
        """A name that no module on ``sys.path`` has."""
        return "_bt_manip_plugin_" + re.sub(r"\W", "_", self.name)

    def load(self) -> Any:
        """Run the file; what fails leaves no module behind."""
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
    """Find the plugins of installed packages."""
    from bt_manip import hookspecs  # with pluggy, which names alone do not need

    return tuple(importlib.metadata.entry_points(group=hookspecs.GROUP))


def in_folders(folders: Iterable[Path]) -> tuple[EntryPoint, ...]:
    """Find the plugins of one file: each ``*.py`` whose name does not begin with ``_``.

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
    """Give the names that block a plugin: its own and its package's, with and without prefix."""
    return block_names(point.name, "" if point.dist is None else str(point.dist.name))


def block_names(name: str, package: str) -> set[str]:
    """Give the names that block a plugin, by its name and its package's, which may be empty."""
    if not package:
        return {name}
    plain = re.sub(r"[-_.]+", "-", package).lower()
    return {name, package, plain, plain.removeprefix(PREFIX)}
