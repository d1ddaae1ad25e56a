"""``bt-manip new``: create packages from templates."""

import os
from pathlib import Path

import click

from bt_manip.cli import PluginGroup, load_chosen_plugins

from .scaffold import KINDS, write_plugin


@click.group(cls=PluginGroup)
def new() -> None:
    """Create a package from a template."""


@new.command("plugin")
@click.argument("name")
@click.option(
    "--kind", type=click.Choice(KINDS), default="behaviour", show_default=True,
    help="What the plugin registers.",
)  # fmt: skip
@click.option(
    "--into", type=click.Path(file_okay=False, path_type=Path), default=Path("."), metavar="DIR",
    help="Folder to write it to.  [default: the current one]",
)  # fmt: skip
def new_plugin(name: str, kind: str, into: Path) -> None:
    """Create the package of a plugin, with tests that pass."""
    os.environ.setdefault("MUJOCO_GL", "disable")
    folder = write_plugin(name, kind, into, load_chosen_plugins())
    click.echo(f"wrote {folder}; next:")
    click.echo(f'  pip install -e "{folder}[dev]"')
    click.echo(f"  pytest {folder}")
