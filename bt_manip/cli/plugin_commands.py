"""Commands of plugins: listed without importing them, imported when they run."""

import ast
import importlib.metadata
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import click

from bt_manip.plugins import PREFIX, PluginSelection, names_of, source_of

COMMAND_GROUP = "bt_manip.commands"
"""Entry-point group: the name of each command, and where its click command is defined."""


class BrokenCommandError(Exception):
    """A command of a plugin that cannot be loaded."""


@dataclass(frozen=True)
class PluginCommand:
    """A command of an installed package.

    Attributes:
        point: Its entry point.
    """

    point: importlib.metadata.EntryPoint

    @property
    def package(self) -> str:
        """Name and version of its package."""
        dist = self.point.dist
        return f"{dist.name} {dist.version}" if dist is not None else self.point.module

    def summary(self) -> str:
        """Return the first line of its help, read from its source file without importing it."""
        path = source_of(self.point.module)
        return _docstring(path, self.point.attr) if path is not None else ""

    def load(self) -> click.Command:
        """Import it.

        Raises:
            BrokenCommandError: If that fails, or it is not a click command.
        """
        try:
            command = self.point.load()
        except (Exception, SystemExit) as error:
            traceback.print_exception(error)
            raise BrokenCommandError(self._broken(f"{type(error).__name__}: {error}")) from error
        if not isinstance(command, click.Command):
            raise BrokenCommandError(self._broken(f"'{self.point.value}' is not a click command"))
        return command

    def _broken(self, problem: str) -> str:
        name = self.point.name
        block = str(self.point.dist.name) if self.point.dist is not None else name
        return (
            f"the command '{name}' of {self.package} cannot be loaded: {problem} "
            f"(to block it: --block {block.removeprefix(PREFIX)})"
        )


def plugin_commands(choice: PluginSelection) -> Mapping[str, PluginCommand]:
    """Return the commands of installed packages by name; of duplicates, the first."""
    found: dict[str, PluginCommand] = {}
    points = importlib.metadata.entry_points(group=COMMAND_GROUP)
    for point in sorted(points, key=lambda p: (p.name, p.value)):
        if not choice.blocks(names_of(point)):
            found.setdefault(point.name, PluginCommand(point))
    return found


def blame(error: BaseException, choice: PluginSelection) -> PluginCommand | None:
    """Return the command whose package an exception came from, if any."""
    owners = {c.point.module.partition(".")[0]: c for c in plugin_commands(choice).values()}
    for frame, _ in reversed(list(traceback.walk_tb(error.__traceback__))):
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if package in owners:
            return owners[package]
    return None


def _docstring(path: Path, function: str) -> str:
    try:
        body = ast.parse(path.read_text(encoding="utf-8")).body
    except (OSError, SyntaxError, ValueError):
        return ""
    for node in body:
        if isinstance(node, ast.FunctionDef) and node.name == function:
            return (ast.get_docstring(node) or "").partition("\n")[0]
    return ""
