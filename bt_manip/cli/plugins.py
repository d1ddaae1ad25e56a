"""``bt-manip plugins``: the plugins and their state."""

import contextlib
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.exit_codes import FAULT, SUCCESS
from bt_manip.cli.json_output import json_option, print_json
from bt_manip.cli.plugin_options import chosen, print_warning, warn_of_unknown
from bt_manip.cli.streams import echo_wrapped

if TYPE_CHECKING:
    from bt_manip.plugins import Plugin, Plugins


@click.command("plugins")
@json_option
@click.option(
    "--check", is_flag=True, help="Print problems only, and exit with 3 if there are any."
)
def show_plugins(as_json: bool, check: bool) -> int:
    """List plugins, what they register, and whether they load."""
    os.environ.setdefault("MUJOCO_GL", "disable")
    from bt_manip.plugins import load_plugins

    # The table says what is broken; a warning would repeat it.
    warn = print_warning if check and not as_json else lambda _: None
    loaded = load_plugins(warn=warn, choice=chosen())
    warn_of_unknown(loaded)
    commands = _commands()
    problems = [problem for _, problem in commands.values() if problem]
    if check:
        problems += _tree_problems(loaded)
    if as_json:
        print_json(plugins=[_row(p, commands) for p in loaded.plugins])
    elif not check:
        for plugin in loaded.plugins:
            _print(_row(plugin, commands))
    for problem in problems:
        click.echo(f"Warning: {problem}", err=True)
    broken = bool(problems) or any(p.status == "broken" for p in loaded.plugins)
    if check and not broken:
        click.echo(f"{len(loaded.plugins)} plugins, nothing is wrong")
    return FAULT if check and broken else SUCCESS


def _tree_problems(loaded: "Plugins") -> list[str]:
    """Return problems of the registered trees, and of the scenes and controllers that they name."""
    from bt_manip.bt import read_tree
    from bt_manip.registry import TreeDefaults, UnknownPartError
    from bt_manip.runner import known_behaviours

    parts, problems = loaded.parts, []
    behaviours = known_behaviours(parts)
    for plugin in loaded.plugins:
        for name in plugin.provides.get("trees", ()):
            found = []
            wants = parts.tree_defaults.get(name, TreeDefaults())
            for there, wanted in (
                (parts.scenes, wants.scene),
                (parts.controllers, wants.controller),
            ):
                try:
                    if wanted is not None:
                        there.owner(wanted)
                except UnknownPartError as error:
                    found.append(str(error))
            path = Path(parts.trees.get(name))
            if path.suffix == ".xml":
                read = read_tree(path, behaviours, library=True).problems
                found += [str(problem) for problem in read if problem.is_error]
            problems += [f"{plugin.label}: tree '{name}': {what}" for what in found]
    return problems


def _commands() -> Mapping[str, tuple[str, str]]:
    """Load all commands of plugins; return the package and the problem of each."""
    from bt_manip.cli.plugin_commands import BrokenCommandError, plugin_commands

    found = {}
    for name, command in plugin_commands(chosen()).items():
        package = command.package.partition(" ")[0]
        try:
            with contextlib.redirect_stdout(sys.stderr):  # what its import prints
                command.load()
            found[name] = (package, "")
        except BrokenCommandError as error:
            found[name] = (package, str(error))
    return found


def _row(plugin: "Plugin", commands: Mapping[str, tuple[str, str]]) -> dict[str, Any]:
    provides = {kind: list(names) for kind, names in plugin.provides.items()}
    own = [n for n, (package, _) in commands.items() if package and package == plugin.package]
    if own:
        provides["commands"] = own
    return {
        "name": plugin.name,
        "version": plugin.version,
        "package": plugin.package,
        "source": plugin.source,
        "status": plugin.status,
        "problem": plugin.problem,
        "provides": provides,
        "observers": [hook.name for hook in plugin.observers],
    }


def _print(row: Mapping[str, Any]) -> None:
    click.echo(f"{row['name']} {row['version']}".rstrip() + f": {row['status']}")
    click.echo(f"  source: {row['source']}")
    if row["problem"]:
        click.echo(f"  problem: {row['problem']}")
    for kind, names in row["provides"].items():
        echo_wrapped(f"  {kind}: {', '.join(names)}")
    if row["observers"]:
        click.echo(f"  watches runs: {', '.join(row['observers'])}")
