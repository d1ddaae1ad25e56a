"""Commands of plugins: listed without importing them, imported when they run."""

import ast
import importlib
import traceback
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import click

from bt_manip.cli.completion import function_in
from bt_manip.cli.plugin_options import print_warning
from bt_manip.plugins import (
    COMMAND_GROUP,
    PREFIX,
    PluginPoint,
    PluginSelection,
    call_single_hook,
    installed,
    label_of,
    names_of,
    source_of,
)


class BrokenCommandError(Exception):
    """A command of a plugin that cannot be loaded."""


@dataclass(frozen=True)
class PluginCommand:
    """A command of a plugin, or its place ``module:function``, in a group or in the program."""

    point: PluginPoint
    name: str
    target: str | click.Command
    group: str = ""

    @property
    def words(self) -> str:
        """The words of the command after ``bt-manip``."""
        return f"{self.group} {self.name}".lstrip()

    @property
    def package(self) -> str:
        """Name and version of its package."""
        return label_of(self.point)

    @property
    def module(self) -> str:
        """Name of the module that defines it."""
        if isinstance(self.target, str):
            return self.target.partition(":")[0]
        return self.point.module

    def summary(self) -> str:
        """Return the first line of its help, read from its source file without importing it."""
        if not isinstance(self.target, str):
            return (getattr(self.target, "help", None) or "").partition("\n")[0]
        path, name = source_of(self.module), self.target.partition(":")[2]
        function = None if path is None else function_in(path, name)
        return "" if function is None else (ast.get_docstring(function) or "").partition("\n")[0]

    def load(self) -> click.Command:
        """Import it; raise a `BrokenCommandError` if that fails or it is no click command."""
        if self.point.group == COMMAND_GROUP:
            print_warning(
                f"the package {self.package} registers the command '{self.name}' by an entry point "
                f"of the group {COMMAND_GROUP}, which is deprecated: use the hook register_commands"
            )
        command: Any = self.target
        try:
            if isinstance(command, str):
                module, _, function = command.partition(":")
                command = getattr(importlib.import_module(module), function)
        except (Exception, SystemExit) as error:
            traceback.print_exception(error)
            raise BrokenCommandError(self._broken(f"{type(error).__name__}: {error}")) from error
        if not isinstance(command, click.Command):
            raise BrokenCommandError(self._broken(f"'{self.target}' is not a click command"))
        return command

    def _broken(self, problem: str) -> str:
        block = self.point.name if self.point.dist is None else str(self.point.dist.name)
        return (
            f"the command '{self.words}' of {self.package} cannot be loaded: {problem} "
            f"(to block it: --block {block.removeprefix(PREFIX)})"
        )


def plugin_commands(choice: PluginSelection) -> Mapping[str, PluginCommand]:
    """Return the commands of plugins by group and name; of duplicates, the first."""

    def command(
        point: PluginPoint, name: str, target: str | click.Command, group: str = ""
    ) -> tuple[str, PluginCommand]:
        found = PluginCommand(point, name, target, group)
        return found.words, found

    found = call_single_hook("register_commands", choice, command)
    for point in sorted(installed(COMMAND_GROUP), key=lambda p: (p.name, p.value)):
        if not (choice.blocked and choice.blocks(names_of(point))):
            found.setdefault(point.name, PluginCommand(point, point.name, point.value))
    return found


def blame(error: BaseException, choice: PluginSelection) -> PluginCommand | None:
    """Return the command whose package an exception came from, if any."""
    owners = {c.module.partition(".")[0]: c for c in plugin_commands(choice).values()}
    for frame, _ in reversed(list(traceback.walk_tb(error.__traceback__))):
        package = str(frame.f_globals.get("__name__", "")).partition(".")[0]
        if package in owners:
            return owners[package]
    return None
