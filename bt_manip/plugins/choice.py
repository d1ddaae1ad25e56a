"""Which plugins a user wants."""

import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

BLOCK_VARIABLE = "BT_MANIP_BLOCK"
"""Environment variable: names of plugins to do without, with commas or spaces between them."""

FOLDERS_VARIABLE = "BT_MANIP_PLUGINS_DIR"
"""Environment variable: folders of plugins of one file, separated as in PATH."""


@dataclass(frozen=True)
class Choice:
    """Which plugins are loaded beside the built-in one.

    Attributes:
        blocked: Names of plugins, or of packages that bring some, that are not to be loaded.
        folders: Folders in which each ``*.py`` is a plugin.
    """

    blocked: frozenset[str] = frozenset()
    folders: tuple[Path, ...] = ()

    @classmethod
    def from_environment(cls, environment: Mapping[str, str] | None = None) -> "Choice":
        """Read what the environment variables say."""
        variables = os.environ if environment is None else environment
        names = re.split(r"[\s,]+", variables.get(BLOCK_VARIABLE, ""))
        folders = variables.get(FOLDERS_VARIABLE, "").split(os.pathsep)
        return cls().extended(names, map(Path, filter(None, folders)))

    def extended(self, blocked: Iterable[str] = (), folders: Iterable[Path] = ()) -> "Choice":
        """Give a choice with more names that are blocked and more folders."""
        more = tuple(folder for folder in dict.fromkeys(folders) if folder not in self.folders)
        return Choice(self.blocked | {name for name in blocked if name}, self.folders + more)

    def blocks(self, names: Iterable[str]) -> bool:
        """Tell whether something with any of these names is not to be loaded."""
        return not self.blocked.isdisjoint(names)
