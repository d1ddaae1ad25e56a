"""Groups of commands to which plugins add further ones."""

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

import click

from bt_manip.cli.plugin_options import add_plugin_options, chosen

if TYPE_CHECKING:
    from bt_manip.cli.plugin_commands import PluginCommand

_FOUND = "bt_manip.commands"


class PluginGroup(click.Group):
    """A group of commands to which plugins add further ones by the hook ``register_commands``.

    Its own commands take precedence. Summaries of the others are read from their source files, so
    that ``--help`` imports none of them.
    """

    @property
    def plugin_group(self) -> str:
        """Its name in the hook."""
        return self.name or ""

    def own_names(self) -> Collection[str]:
        """Return the names of its own commands."""
        return self.commands

    def own_command(self, name: str) -> click.Command:
        """Return one of its own commands."""
        return self.commands[name]

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the sub-commands."""
        return sorted({*self.own_names(), *self._added(ctx)})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a sub-command, with the options that select plugins."""
        if cmd_name in self.own_names():
            command = self.own_command(cmd_name)
        elif (added := self._added(ctx).get(cmd_name)) is not None:
            command = added.load()
        else:
            return None
        add_plugin_options(command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the sub-commands with the first line of their help."""
        rows, own, added = [], self.own_names(), self._added(ctx)
        for name in self.list_commands(ctx):
            if name in own:
                rows.append((name, self.own_command(name).get_short_help_str(formatter.width)))
            else:
                rows.append((name, f"{added[name].summary()} ({added[name].package})".lstrip()))
        with formatter.section("Commands"):
            formatter.write_dl(rows)

    def _added(self, ctx: click.Context) -> "Mapping[str, PluginCommand]":
        """Return the commands of plugins; they are searched once for a command line."""
        if _FOUND not in ctx.meta:
            from bt_manip.cli.plugin_commands import plugin_commands

            ctx.meta[_FOUND] = plugin_commands(chosen(ctx))
        commands: Mapping[str, PluginCommand] = ctx.meta[_FOUND]
        return {one.name: one for one in commands.values() if one.group == self.plugin_group}
