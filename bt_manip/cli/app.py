"""The command ``bt-manip``, its sub-commands and exit codes."""

import errno
import importlib
import os
import sys
import traceback
from collections.abc import Collection

import click

from bt_manip.cli.exit_codes import BAD_INPUT, FAULT, INTERRUPTED, SUCCESS, exit_code_of
from bt_manip.cli.interrupt import Interrupt
from bt_manip.cli.plugin_group import PluginGroup
from bt_manip.cli.plugin_options import chosen, plugin_options
from bt_manip.cli.streams import unfailing
from bt_manip.exceptions import BtManipError, did_you_mean, with_short_values
from bt_manip.packages import missing

COMMANDS = {
    "evaluate": "bt_manip.cli.evaluate:evaluate",
    "list": "bt_manip.cli.listing:list_parts",
    "models": "bt_manip.cli.models:models",
    "plugins": "bt_manip.cli.plugins:show_plugins",
    "run": "bt_manip.cli.run:run",
    "scene": "bt_manip.cli.scene:scene",
    "sweep": "bt_manip.cli.evaluate:sweep",
    "tree": "bt_manip.cli.tree:tree",
}
"""Module and attribute of each sub-command; it is imported when it is needed."""


class Program(PluginGroup):
    """The program: commands of `COMMANDS` are imported when they are needed."""

    plugin_group = ""

    def own_names(self) -> Collection[str]:
        """Return the names of the built-in commands."""
        return COMMANDS

    def own_command(self, name: str) -> click.Command:
        """Import a built-in command."""
        module, _, attribute = COMMANDS[name].partition(":")
        command = getattr(importlib.import_module(module), attribute)
        assert isinstance(command, click.Command)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return the sub-command; the error about one of a package tells how to install it."""
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError:
            if package := missing("command", args[0]):
                raise click.UsageError(f"the command '{args[0]}' {package}", ctx) from None
            near = did_you_mean(args[0], self.list_commands(ctx))
            raise click.UsageError(f"no such command '{args[0]}'{near}", ctx) from None


@click.group(cls=Program, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="bt-manip")
@plugin_options
@click.pass_context
def app(ctx: click.Context) -> None:
    """Run manipulation tasks, written as behaviour trees, on a simulated robot cell."""
    if ctx.invoked_subcommand != "run":  # it writes a report when it is interrupted
        ctx.with_resource(ctx.obj.raised())


@unfailing("stderr")
def run_app(interrupt: Interrupt, arguments: list[str] | None = None) -> int:
    """Run the command line.

    Args:
        interrupt: The handler of Ctrl-C.
        arguments: Arguments of the command; None: those of the process.

    Returns:
        The exit code, one of `exit_codes`.
    """
    try:
        code = app.main(arguments, prog_name="bt-manip", standalone_mode=False, obj=interrupt)
        sys.stdout.flush()
        return code if isinstance(code, int) else SUCCESS
    except (KeyboardInterrupt, click.Abort) as error:
        if isinstance(error.__cause__, EOFError):  # what Click takes for the end of the input
            _print_fault(error.__cause__)
            return FAULT
        return INTERRUPTED
    except click.ClickException as error:
        error.message = with_short_values(error.message)  # type: ignore[misc]  # Final in Click
        error.show()
        return BAD_INPUT
    except BtManipError as error:
        click.echo(f"Error: {error}", err=True)
        return exit_code_of(error)
    except BrokenPipeError:
        _drop_output()
        return SUCCESS
    except Exception as error:
        if isinstance(error, OSError) and error.errno == errno.ENOSPC:
            _drop_output()
            click.echo(f"Error: {error.filename or 'standard output'}: {error.strerror}", err=True)
            return FAULT
        if isinstance(error, OSError) and error.errno in (errno.ENAMETOOLONG, errno.EACCES):
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
        click.echo(f"Error: a command of {command.package}: {what}", err=True)
