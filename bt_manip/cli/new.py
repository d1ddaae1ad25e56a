"""``bt-manip new``: begin something of one's own."""

import os
from pathlib import Path

import click

from bt_manip.cli.plugin_options import load_chosen_plugins

KINDS = ("object", "controller", "robot", "behaviour", "planner")


@click.group()
def new() -> None:
    """Begin a package of your own."""


@new.command("plugin")
@click.argument("name")
@click.option(
    "--kind", type=click.Choice(KINDS), default="behaviour", show_default=True,
    help="What the plugin brings.",
)  # fmt: skip
@click.option(
    "--into", type=click.Path(file_okay=False, path_type=Path), default=Path("."), metavar="DIR",
    help="Folder to write it in; the present one without.",
)  # fmt: skip
def new_plugin(name: str, kind: str, into: Path) -> None:
    """Write the package of a plugin, with tests that pass at once."""
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.plugins import write_plugin

    folder = write_plugin(name, kind, into, load_chosen_plugins())
    click.echo(f"wrote {folder}; go on with:")
    click.echo(f'  pip install -e "{folder}[dev]"')
    click.echo(f"  pytest {folder}")
