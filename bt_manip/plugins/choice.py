"""Selection of the plugins to load."""

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

BLOCK_VARIABLE = "BT_MANIP_BLOCK"
"""Environment variable: names of blocked plugins, separated by commas or spaces."""

FOLDERS_VARIABLE = "BT_MANIP_PLUGINS_DIR"
"""Environment variable: folders of single-file plugins, separated as in PATH."""


@dataclass(frozen=True)
class Choice:
    """Selection of plugins beside the built-in one.

    Attributes:
        blocked: Names of plugins, or of their packages, that are not loaded.
        folders: Folders in which each ``*.py`` is a plugin.
    """

    blocked: frozenset[str] = frozenset()
    folders: tuple[Path, ...] = ()

    @classmethod
    def from_environment(cls, environment: Mapping[str, str] | None = None) -> "Choice":
        """Read the selection from environment variables."""
        variables = os.environ if environment is None else environment
        names = re.split(r"[\s,]+", variables.get(BLOCK_VARIABLE, ""))
        folders = variables.get(FOLDERS_VARIABLE, "").split(os.pathsep)
        return cls().extended(names, map(Path, filter(None, folders)))

    def extended(self, blocked: Iterable[str] = (), folders: Iterable[Path] = ()) -> "Choice":
        """Return a selection with further blocked names and folders."""
        more = tuple(folder for folder in dict.fromkeys(folders) if folder not in self.folders)
        return Choice(self.blocked | {name for name in blocked if name}, self.folders + more)

    def blocks(self, names: Iterable[str]) -> bool:
        """Return whether any of these names is blocked."""
        return not self.blocked.isdisjoint(names)
