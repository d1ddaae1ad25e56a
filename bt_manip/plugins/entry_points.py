"""Entry points of plugins: installed packages, and single files in a folder."""

import contextlib
import importlib.util
import os
import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_manip.exceptions import BtManipError

if TYPE_CHECKING:
    from importlib.metadata import Distribution, EntryPoint

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


@dataclass(frozen=True)
class PluginPoint:
    """Entry point of a plugin, with the interface of `importlib.metadata.EntryPoint`.

    Importing `importlib.metadata` and reading all entry points would add a third to the time of
    ``bt-manip run --help``.

    Attributes:
        name: Name of the plugin.
        value: Place of the plugin: ``module``, or ``module:attribute``.
        group: The group.
        folder: Folder with the metadata of its package; None for a single file.
    """

    name: str
    value: str
    group: str = GROUP
    folder: Path | None = None

    @property
    def module(self) -> str:
        """Name of the module."""
        return self.value.partition(":")[0].strip()

    @property
    def dist(self) -> "Distribution | None":
        """Its package."""
        from importlib.metadata import Distribution

        return None if self.folder is None else Distribution.at(self.folder)

    def load(self) -> Any:
        """Import it."""
        attributes = self.value.partition(":")[2].strip()
        module = importlib.import_module(self.module)
        return reduce(getattr, filter(None, attributes.split(".")), module)


class FilePlugin(PluginPoint):
    """Single-file plugin, named by its stem and loaded by its path, not through ``sys.path``."""

    def __init__(self, path: Path) -> None:
        super().__init__(path.stem, str(path))

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


def installed(group: str = GROUP) -> tuple[PluginPoint, ...]:
    """Return the entry points of installed packages in ``bt_manip`` or a group that begins so."""
    found: dict[str, tuple[Path, str]] = {}
    for folder in _metadata_folders():
        text = _text(folder / "entry_points.txt")
        if f"[{GROUP}" in text:
            found.setdefault(_normalized(_field(folder, "Name")), (folder, text))
    return tuple(
        PluginPoint(name.strip(), value.strip(), group, folder)
        for folder, text in found.values()
        for name, value in _section(text, group)
    )


def label_of(point: "PluginPoint | EntryPoint") -> str:
    """Return the name and version of a plugin's package, or the name of its file."""
    folder = getattr(point, "folder", None)
    if folder is None:
        return Path(point.value).name
    return f"{_field(folder, 'Name')} {_field(folder, 'Version')}"


def _metadata_folders() -> Iterator[Path]:
    """Yield the folders with the metadata of installed packages; the first of a name counts."""
    for place in sys.path:
        with contextlib.suppress(OSError):
            names = sorted(os.listdir(place or "."))
            yield from (Path(place, n) for n in names if n.endswith((".dist-info", ".egg-info")))


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ""


def _section(text: str, group: str) -> Iterator[tuple[str, str]]:
    """Yield names and values of a section of ``entry_points.txt``."""
    inside = False
    for line in map(str.strip, text.splitlines()):
        if line.startswith("["):
            inside = line == f"[{group}]"
        elif inside and "=" in line and not line.startswith(("#", ";")):
            name, _, value = line.partition("=")
            yield name, value


def _field(folder: Path, name: str) -> str:
    text = _text(folder / "METADATA") or _text(folder / "PKG-INFO")
    match = re.search(rf"^{name}: *(.*)$", text, re.MULTILINE)
    return match[1].strip() if match else ""


_NO_PLUGIN = re.compile(r"_|test_|conftest\.py$|.*_test\.py$")
"""Names of files in a folder of plugins that are none: private modules, and those of pytest."""


def in_folders(folders: Iterable[Path]) -> tuple[PluginPoint, ...]:
    """Return the single-file plugins: each ``*.py``, except tests and names that begin with _."""
    found: list[PluginPoint] = []
    for folder in folders:
        if not folder.is_dir():
            raise BtManipError(f"no folder '{folder}' to take plugins from")
        files = sorted(folder.resolve().glob("*.py"))
        found += [FilePlugin(p) for p in files if not p.is_dir() and not _NO_PLUGIN.match(p.name)]
    return tuple(found)


def names_of(point: "PluginPoint | EntryPoint") -> set[str]:
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
