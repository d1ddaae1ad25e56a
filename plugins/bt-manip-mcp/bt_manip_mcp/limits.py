"""What the client of a server may ask for, checked before a command sees it."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from mcp.server.mcpserver.exceptions import ToolError

_NAME: Final = re.compile(r"\w[\w .+-]*")
_DOCUMENT: Final = re.compile(rf"(.*?\.(?:xml|py))(:{_NAME.pattern})?")
_KEY: Final = re.compile(r"\w[\w.]*")


@dataclass(frozen=True)
class Limits:
    """The limits of a server, which only its user sets.

    Attributes:
        folder: Where files are read and written; absolute and without links.
        seconds: Wall time after which a request is stopped [s].
        episodes: Most cycles, episodes or seeds of a request.
        allow_python: Whether trees may be Python code of the folder.
        blocked: Names of plugins that are not loaded.
        plugins: Folders with plugins of the user; absolute.
    """

    folder: Path
    seconds: float = 120.0
    episodes: int = 100
    allow_python: bool = False
    blocked: tuple[str, ...] = ()
    plugins: tuple[Path, ...] = ()

    def file(self, text: str, *suffixes: str) -> str:
        """Return the path of a file, relative to the folder.

        Raises:
            ToolError: If it is outside of the folder, also by ``..`` or a link, or of another kind.
        """
        if "\0" in text or not text.strip():
            raise ToolError(f"refused: {text!r} is no path")
        path = (self.folder / text).resolve()
        if not path.is_relative_to(self.folder):
            raise ToolError(f"refused: '{text}' is outside of the folder of this server")
        if path.suffix not in suffixes:
            raise ToolError(f"refused: '{text}' is no {' or '.join(suffixes)} file")
        return str(path.relative_to(self.folder))

    def tree(self, text: str) -> str:
        """Return a tree: a registered name, or a document of the folder.

        Raises:
            ToolError: If it is neither, or code, and code is not allowed.
        """
        if _NAME.fullmatch(text) and not text.endswith((".xml", ".py")):
            return text
        if (document := _DOCUMENT.fullmatch(text)) is None:
            raise ToolError(f"refused: {text!r} is no name of a tree, and no .xml or .py file")
        path, name = document.groups("")
        if path.endswith(".py") and not self.allow_python:
            raise ToolError(f"refused: '{text}' is Python code, which needs --allow-python")
        return self.file(path, ".xml", ".py") + name

    def part(self, option: str, text: str) -> list[str]:
        """Return the option of a registered part or of a file of the folder; none for no text.

        Raises:
            ToolError: If it is neither.
        """
        if not text:
            return []
        is_name = _NAME.fullmatch(text) and not text.endswith(".toml")
        return [f"{option}={text if is_name else self.file(text, '.toml')}"]

    def number(self, what: str, value: int) -> str:
        """Return a number of cycles, episodes or seeds as text.

        Raises:
            ToolError: If there are too few or too many.
        """
        if not 1 <= value <= self.episodes:
            raise ToolError(f"refused: {what} is {value}; this server takes 1 to {self.episodes}")
        return str(value)

    def settings(self, values: Mapping[str, str | int | float | bool]) -> list[str]:
        """Return the options that set keys of the tree.

        Raises:
            ToolError: If a key is none.
        """
        found = []
        for key, value in values.items():
            if not _KEY.fullmatch(key) or "\0" in str(value):
                raise ToolError(f"refused: {key!r} is no key of a tree")
            text = str(value).lower() if isinstance(value, bool) else str(value)
            found.append(f"--set={key}={text}")
        return found
