"""The options ``--block`` and ``--plugins-dir`` of all commands."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import click

if TYPE_CHECKING:
    from bt_manip.plugins import Plugins, PluginSelection

BUILTIN = "builtin"
_BLOCKED = "bt_manip.blocked"
_FOLDERS = "bt_manip.folders"

C = TypeVar("C", bound=Callable[..., object] | click.Command)


def plugin_options(command: C) -> C:
    """Add ``--block`` and ``--plugins-dir`` to a command; `chosen` reads them."""
    block = click.option(
        "--block", multiple=True, metavar="NAME", is_eager=True,
        expose_value=False, callback=_keeper(_BLOCKED),
        help="Do not load a plugin; may be given more than once. Also BT_MANIP_BLOCK=NAME,NAME.",
    )  # fmt: skip
    folder = click.option(
        "--plugins-dir", multiple=True, metavar="DIR", is_eager=True,
        type=click.Path(exists=True, file_okay=False, path_type=Path),
        expose_value=False, callback=_keeper(_FOLDERS),
        help="Load each DIR/*.py as a plugin; may be given more than once. Also "
        "BT_MANIP_PLUGINS_DIR=DIR:DIR.",
    )  # fmt: skip
    return block(folder(command))


def add_plugin_options(command: click.Command) -> None:
    """Add the options of `plugin_options` to a command and its sub-commands that lack them."""
    if not any(parameter.name == "block" for parameter in command.params):
        plugin_options(command)
    if isinstance(command, click.Group):
        for one in command.commands.values():
            add_plugin_options(one)


def _keeper(key: str) -> Callable[[click.Context, click.Parameter, tuple[object, ...]], None]:
    def keep(ctx: click.Context, parameter: click.Parameter, values: tuple[object, ...]) -> None:
        # Values before and after a sub-command add up.
        ctx.meta[key] = (*ctx.meta.get(key, ()), *values)

    return keep


def chosen(ctx: click.Context | None = None) -> "PluginSelection":
    """Return the choice of the options and the environment variables together."""
    from bt_manip.plugins import PluginSelection

    ctx = ctx or click.get_current_context(silent=True)
    meta = {} if ctx is None else ctx.meta
    return PluginSelection.from_environment().extended(
        meta.get(_BLOCKED, ()), meta.get(_FOLDERS, ())
    )


def load_chosen_plugins() -> "Plugins":
    """Load the chosen plugins, and print a warning for each that is broken."""
    from bt_manip.plugins import load_plugins

    plugins = load_plugins(warn=print_warning, choice=chosen())
    warn_of_unknown(plugins)
    return plugins


def warn_of_unknown(plugins: "Plugins") -> None:
    """Print a warning for each name after ``--block`` that no plugin has."""
    from bt_manip.exceptions import did_you_mean
    from bt_manip.plugins import COMMAND_GROUP, installed, names_of

    ctx = click.get_current_context(silent=True)
    wanted = () if ctx is None else ctx.meta.get(_BLOCKED, ())
    if not wanted:
        return
    known = set().union(*(plugin.names for plugin in plugins.plugins))
    known = known.union(*map(names_of, installed(COMMAND_GROUP)))
    for name in wanted:
        if name == BUILTIN:
            print_warning(f"--block {name}: built-in parts cannot be blocked")
        elif name not in known:
            print_warning(f"--block {name}: there is no such plugin{did_you_mean(name, known)}")


def print_warning(message: str) -> None:
    """Print a warning to the error stream."""
    from bt_manip.exceptions import with_short_values

    click.echo(with_short_values(f"Warning: {message}"), err=True)
