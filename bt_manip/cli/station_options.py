"""Options of several commands: the parts of a station, the settings of its tree, workers."""

from collections.abc import Callable
from typing import Any, TypeVar

import click

from bt_manip.cli.completion import complete_key, complete_part

Command = TypeVar("Command", bound=Callable[..., Any])

_OPTIONS = (
    click.option(
        "--robot", default="panda", show_default=True, metavar="R",
        shell_complete=complete_part("robots"),
        help="Robot to use: a registered name, or path.toml that describes one.",
    ),
    click.option(
        "--controller", metavar="C",
        shell_complete=complete_part("controllers"),
        help="Controller of the arm.  [default: the tree's, or computed_torque]",
    ),
    click.option(
        "--scene", metavar="S",
        shell_complete=complete_part("scenes"),
        help="Robots and objects in the cell: a registered name, or path.toml.  [default: the "
        "tree's, or table_and_basket]",
    ),
    click.option(
        "--planner", default="rrt_connect", show_default=True, metavar="P",
        shell_complete=complete_part("planners"),
        help="Planner of collision-free paths.",
    ),
    click.option(
        "--set", "settings", multiple=True, metavar="KEY=VALUE", shell_complete=complete_key,
        help="Set a key that the tree declares; may be given more than once.",
    ),
)  # fmt: skip

workers_option = click.option(
    "--workers", type=click.IntRange(min=1), metavar="N",
    help="Number of processes, or of workers on a cluster.  [default: one for each core]",
)  # fmt: skip
"""Adds ``--workers`` to a command."""


def station_options(command: Command) -> Command:
    """Add ``--robot``, ``--controller``, ``--scene``, ``--planner`` and ``--set`` to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command
