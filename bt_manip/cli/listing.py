"""``bt-manip list``: what there is to use."""

import inspect
import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.plugin_options import load_chosen_plugins, plugin_options

if TYPE_CHECKING:
    from bt_manip.plugins import Plugins

LISTED = (
    "trees", "behaviours", "objects", "robots", "grippers", "controllers", "planners",
    "scenes", "model_sources", "recorders", "plugins",
)  # fmt: skip


@click.command("list")
@click.argument("kind", required=False, type=click.Choice(LISTED))
@plugin_options
def list_parts(kind: str | None) -> None:
    """List what is registered, with the plugin that it is from.

    Without a kind, everything is listed.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")
    plugins = load_chosen_plugins()
    for chosen in [kind] if kind else LISTED:
        if kind is None:
            click.echo(f"{chosen}:")
        indent = "  " if kind is None else ""
        for line in _aligned(list(_rows(plugins, chosen))):
            click.echo(indent + line)


def _rows(plugins: "Plugins", kind: str) -> Iterator[tuple[str, str, str]]:
    """Give name, origin and meaning of each part."""
    if kind == "plugins":
        for plugin in plugins.plugins:
            counts = (
                f"{len(names)} {what if len(names) > 1 else what[:-1]}"
                for what, names in plugin.provides.items()
            )
            summary = "blocked" if plugin.blocked else ""
            if plugin.problem:
                summary = f"left out: {plugin.problem}"
            yield plugin.name, plugin.version, summary or ", ".join(counts)
        return
    registry = plugins.parts.by_kind()[kind]
    for name in registry.names():
        yield name, registry.owner(name), _summary(registry.get(name))
    if kind == "behaviours":
        from bt_manip.bt import BehaviourRegistry

        language = BehaviourRegistry()
        for name in language.names():
            yield name, "tree language", _summary(language.get(name))


def _summary(part: Any) -> str:
    """Say in one line what a part is."""
    if isinstance(part, str):
        return part
    if not callable(part):  # a robot's description
        return str(getattr(part, "model", ""))
    # Not that of a base class, which getdoc() would give.
    return inspect.cleandoc(part.__doc__ or "").partition("\n")[0]


def _aligned(rows: list[tuple[str, str, str]]) -> Iterator[str]:
    widths = [max((len(row[i]) for row in rows), default=0) for i in range(2)]
    for name, origin, summary in rows:
        yield f"{name:{widths[0]}}  {origin:{widths[1]}}  {summary}".rstrip()
