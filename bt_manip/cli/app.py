"""The command ``bt-manip``, its sub-commands and exit codes."""

import errno
import importlib
import os
import sys
import traceback
from collections.abc import Mapping
from typing import TYPE_CHECKING

import click

from bt_manip.cli.exit_codes import BAD_INPUT, FAULT, INTERRUPTED, SUCCESS
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.plugin_options import add_plugin_options, chosen, plugin_options
from bt_manip.cli.streams import unfailing
from bt_manip.exceptions import BtManipError, with_short_values
from bt_manip.packages import missing

if TYPE_CHECKING:
    from bt_manip.cli.plugin_commands import PluginCommand

_FOUND = "bt_manip.commands"

COMMANDS = {
    "evaluate": "bt_manip.cli.evaluate:evaluate",
    "export": "bt_manip.cli.export:export",
    "list": "bt_manip.cli.listing:list_parts",
    "models": "bt_manip.cli.models:models",
    "new": "bt_manip.cli.new:new",
    "plugins": "bt_manip.cli.plugins:show_plugins",
    "robot": "bt_manip.cli.robot:robot",
    "run": "bt_manip.cli.run:run",
    "scene": "bt_manip.cli.scene:scene",
    "stress": "bt_manip.cli.stress:stress",
    "sweep": "bt_manip.cli.evaluate:sweep",
    "tree": "bt_manip.cli.tree:tree",
}
"""Module and attribute of each sub-command; it is imported when it is needed."""


class LazyGroup(click.Group):
    """A group that imports a sub-command when it is needed.

    Plugins register sub-commands by the entry-point group ``bt_manip.commands``. Their summaries
    are read from their source files, so that ``--help`` imports none of them.
    """

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the sub-commands."""
        return sorted({*COMMANDS, *_plugin_commands(ctx)})

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a sub-command; built-in ones take precedence."""
        if cmd_name in COMMANDS:
            module, _, attribute = COMMANDS[cmd_name].partition(":")
            command = getattr(importlib.import_module(module), attribute)
            assert isinstance(command, click.Command)
        elif cmd_name in _plugin_commands(ctx):
            command = _plugin_commands(ctx)[cmd_name].load()
        elif package := missing(cmd_name):
            raise click.UsageError(f"'{cmd_name}' {package}", ctx)
        else:
            return None
        add_plugin_options(command)
        return command

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """List the sub-commands with the first line of their help."""
        rows, plugins = [], _plugin_commands(ctx)
        for name in self.list_commands(ctx):
            if name in COMMANDS:
                command = self.get_command(ctx, name)
                assert command is not None
                rows.append((name, command.get_short_help_str(formatter.width)))
            else:
                summary = plugins[name].summary()
                rows.append((name, f"{summary} ({plugins[name].package})".lstrip()))
        with formatter.section("Commands"):
            formatter.write_dl(rows)


def _plugin_commands(ctx: click.Context) -> Mapping[str, "PluginCommand"]:
    """Return the commands of plugins; packages are searched once per command line."""
    if _FOUND not in ctx.meta:
        from bt_manip.cli.plugin_commands import plugin_commands

        ctx.meta[_FOUND] = plugin_commands(chosen(ctx))
    return ctx.meta[_FOUND]


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="bt-manip")
@plugin_options
@click.pass_context
def app(ctx: click.Context) -> None:
    """Run manipulation tasks, written as behaviour trees, on a simulated robot cell."""
    if ctx.invoked_subcommand != "run":  # it writes a report when it is interrupted
        ctx.with_resource(ctx.obj.raised())


def run_app(interrupt: Interrupt, arguments: list[str] | None = None) -> int:
    """Run the command line.

    Args:
        interrupt: The handler of Ctrl-C.
        arguments: Arguments of the command; None: those of the process.

    Returns:
        The exit code, one of `exit_codes`.
    """
    with unfailing("stderr"):
        return _run_app(interrupt, arguments)


def _run_app(interrupt: Interrupt, arguments: list[str] | None) -> int:
    try:
        code = app.main(arguments, prog_name="bt-manip", standalone_mode=False, obj=interrupt)
        sys.stdout.flush()
        return code if isinstance(code, int) else SUCCESS
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    except click.ClickException as error:
        error.message = with_short_values(error.message)  # type: ignore[misc]  # Final in Click
        error.show()
        return BAD_INPUT
    except BtManipError as error:
        click.echo(f"Error: {error}", err=True)
        return BAD_INPUT
    except BrokenPipeError:
        _drop_output()
        return SUCCESS
    except Exception as error:
        if isinstance(error, OSError) and error.errno == errno.ENOSPC:
            _drop_output()
            click.echo(f"Error: {error.filename or 'standard output'}: {error.strerror}", err=True)
            return FAULT
        if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
            path = with_short_values(f"'{error.filename}'")
            click.echo(f"Error: {path}: {error.strerror}", err=True)
            return BAD_INPUT
        if interrupt.requested:  # an import turned it into another exception
            return INTERRUPTED
        _print_fault(error)
        return FAULT


def _drop_output() -> None:
    """Discard unwritten output, so that Python's flush at exit does not fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _print_fault(error: Exception) -> None:
    """Print an internal fault, with the plugin whose command it came from."""
    from bt_manip.cli.plugin_commands import BrokenCommandError, blame

    if isinstance(error, BrokenCommandError):
        click.echo(f"Error: {error}", err=True)
        return
    traceback.print_exception(error)
    command = blame(error, chosen())
    if command is not None:
        what = f"{type(error).__name__}: {error}"
        click.echo(
            f"Error: the command '{command.point.name}' of {command.package}: {what}", err=True
        )
