"""The command ``bt-manip`` and where its sub-commands are."""

import importlib
import importlib.util
import os
import sys
import traceback

import click

from bt_manip.cli.interrupt import INTERRUPTED, Interrupt
from bt_manip.exceptions import BtManipError

BAD_INPUT = 2
FAULT = 3

COMMANDS = {
    "list": "bt_manip.cli.listing:list_parts",
    "run": "bt_manip.cli.run:run",
    "tree": "bt_manip.cli.tree:tree",
}
"""Sub-commands and where they are; each is imported when it is asked for."""


class LazyGroup(click.Group):
    """A group that imports a sub-command when somebody asks for it."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Name the sub-commands."""
        return [name for name in sorted(COMMANDS) if self._exists(name)]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a sub-command."""
        if not self._exists(cmd_name):
            return None
        module, _, attribute = COMMANDS[cmd_name].partition(":")
        command = getattr(importlib.import_module(module), attribute)
        assert isinstance(command, click.Command)
        return command

    @staticmethod
    def _exists(name: str) -> bool:
        place = COMMANDS.get(name, "")
        return bool(place) and importlib.util.find_spec(place.partition(":")[0]) is not None


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="bt-manip")
@click.pass_context
def app(ctx: click.Context) -> None:
    """Run manipulation tasks, written as behaviour trees, on a simulated robot cell."""
    if ctx.invoked_subcommand != "run":  # which has a report to write, whenever it is interrupted
        ctx.with_resource(ctx.obj.raised())


def run_app(interrupt: Interrupt, arguments: list[str] | None = None) -> int:
    """Run the command line.

    Args:
        interrupt: What listens to Ctrl-C.
        arguments: What stands behind ``bt-manip``; those of the process when None.

    Returns:
        The exit code: 0, 1 when a cycle failed, 2 for bad input, 3 for a fault inside, 130 when
        interrupted.
    """
    try:
        code = app.main(arguments, prog_name="bt-manip", standalone_mode=False, obj=interrupt)
        sys.stdout.flush()
        return int(code or 0)
    except (KeyboardInterrupt, click.Abort):
        return INTERRUPTED
    except click.ClickException as error:
        error.show()
        return BAD_INPUT
    except BtManipError as error:
        click.echo(f"Error: {error}", err=True)
        return BAD_INPUT
    except BrokenPipeError:
        # Who read the output is gone; Python's own flush at exit must not fail on it again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception:
        if interrupt.requested:  # the interrupt came out of an import as something else
            return INTERRUPTED
        traceback.print_exc()
        return FAULT
