"""Commands of plugins: listed without loading anything, loaded when asked for."""

import ast
import importlib.machinery
import importlib.metadata
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import click

from bt_manip.plugins import PREFIX, Choice, names_of

GROUP = "bt_manip.commands"
"""Name of the entry-point group: the command's name, and where its click command is."""


class BrokenCommandError(Exception):
    """A command of a plugin that cannot be loaded."""


@dataclass(frozen=True)
class PluginCommand:
    """A command that a package brings.

    Attributes:
        point: Where it is.
    """

    point: importlib.metadata.EntryPoint

    @property
    def package(self) -> str:
        """Name and version of the package that brings it."""
        dist = self.point.dist
        return f"{dist.name} {dist.version}" if dist is not None else self.point.module

    def summary(self) -> str:
        """Read the first line of its help in its source, without importing anything of it."""
        path = _source(self.point.module)
        return _docstring(path, self.point.attr) if path is not None else ""

    def load(self) -> click.Command:
        """Import it.

        Raises:
            BrokenCommandError: When that fails, or it is no click command.
        """
        try:
            command = self.point.load()
        except (Exception, SystemExit) as error:
            traceback.print_exception(error)
            raise BrokenCommandError(self._broken(f"{type(error).__name__}: {error}")) from error
        if not isinstance(command, click.Command):
            raise BrokenCommandError(self._broken(f"'{self.point.value}' is no click command"))
        return command

    def _broken(self, problem: str) -> str:
        name = self.point.name
        block = str(self.point.dist.name) if self.point.dist is not None else name
        return (
            f"the command '{name}' of {self.package} cannot be loaded: {problem} "
            f"(to do without it: --block {block.removeprefix(PREFIX)})"
        )


def plugin_commands(choice: Choice) -> Mapping[str, PluginCommand]:
    """Find the commands of installed packages, by name; of two with one name, the first."""
    found: dict[str, PluginCommand] = {}
    points = importlib.metadata.entry_points(group=GROUP)
    for point in sorted(points, key=lambda p: (p.name, p.value)):
        if not choice.blocks(names_of(point)):
            found.setdefault(point.name, PluginCommand(point))
    return found


def blame(error: BaseException, choice: Choice) -> PluginCommand | None:
    """Name the command whose package an exception came out of."""
    owners = {c.point.module.partition(".")[0]: c for c in plugin_commands(choice).values()}
    for frame, _ in reversed(list(traceback.walk_tb(error.__traceback__))):
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if package in owners:
            return owners[package]
    return None


def _source(module: str) -> Path | None:
    """Find a module's file without importing the packages that it is in."""
    places: list[str] | None = None
    parts = module.split(".")
    for i in range(len(parts)):
        spec = importlib.machinery.PathFinder.find_spec(".".join(parts[: i + 1]), places)
        if spec is None:
            return None
        places = list(spec.submodule_search_locations or ())
    return Path(spec.origin) if spec is not None and spec.origin else None


def _docstring(path: Path, function: str) -> str:
    try:
        body = ast.parse(path.read_text(encoding="utf-8")).body
    except (OSError, SyntaxError, ValueError):
        return ""
    for node in body:
        if isinstance(node, ast.FunctionDef) and node.name == function:
            return (ast.get_docstring(node) or "").partition("\n")[0]
    return ""
