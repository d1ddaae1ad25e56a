"""``bt-manip list``: registered parts."""

import inspect
import os
from collections.abc import Iterator, Mapping
from dataclasses import is_dataclass
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.completion import (
    complete_kind,
    complete_listed,
    complete_part,
    listed,
    part_names,
)
from bt_manip.cli.json_output import json_option, print_json
from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.cli.streams import echo_wrapped
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.packages import suggestion
from bt_manip.parameters import parameters_of

if TYPE_CHECKING:
    from bt_manip.parameters import Parameter
    from bt_manip.plugins import Plugins


TASKS = "tasks"


@click.command("list")
@click.argument("kind", required=False, metavar="[KIND|NAME]", shell_complete=complete_kind)
@click.argument("name", required=False, shell_complete=complete_listed)
@click.option(
    "--robot", "robots", multiple=True, metavar="R", shell_complete=complete_part("robots"),
    help="With tasks: a registered name, or path.toml that describes one; may be given more than "
    "once. Default: all registered robots.",
)  # fmt: skip
@click.option(
    "--episodes", type=click.IntRange(min=0), metavar="N", default=0,
    help="With tasks: also run N episodes of each in simulation, and stop at one that fails.",
)  # fmt: skip
@json_option
def list_parts(
    kind: str | None, name: str | None, robots: tuple[str, ...], episodes: int, as_json: bool
) -> None:
    """List registered parts with the plugin of each.

    Without a KIND, everything is listed. With a NAME, only that part, with its documentation and
    its ports or parameters; a KIND before it chooses between parts of the same name.

    Kinds: trees, behaviours, dialects, conversions, objects, robots, grippers, controllers,
    planners, scenes, backends, pose_sources, model_sources, model_formats, model_caches, recorders,
    views, commands, modifiers, pools, contracts, plugins, and those that plugins declare. The kind
    tasks lists which robot can do which tree, with the reason where not: the station is built,
    starts are sampled, and the first motion of each is planned.
    """
    os.environ.setdefault("MUJOCO_GL", "disable")
    if (robots or episodes) and kind != TASKS:
        raise BtManipError("--robot and --episodes are for: bt-manip list tasks")
    plugins = load_chosen_plugins()
    if kind == TASKS:
        _list_tasks(plugins, name, robots, episodes, as_json)
    elif kind is not None and (name is not None or kind not in listed(plugins)):
        if name is not None and kind not in listed(plugins):
            raise BtManipError(f"there is no kind '{kind}'{did_you_mean(kind, listed(plugins))}")
        found = _any(plugins, kind) if name is None else [_described(plugins, kind, name)]
        if as_json:
            print_json(parts=found)
        else:
            _print_described(found)
    else:
        kinds = [kind] if kind else listed(plugins)
        rows = {one: list(_rows(plugins, one)) for one in kinds}
        if as_json:
            print_json(parts=[_part(one, row) for one in kinds for row in rows[one]])
        else:
            _print_rows(rows, indent="" if kind else "  ")


def _print_rows(rows: Mapping[str, list[tuple[str, str, str]]], indent: str) -> None:
    """Print parts by kind; with an indent, the kinds too."""
    for kind, found in rows.items():
        if indent:
            click.echo(f"{kind}:")
        widths = [max((len(row[i]) for row in found), default=0) for i in range(2)]
        for name, origin, summary in found:
            line = f"{indent}{name:{widths[0]}}  {origin:{widths[1]}}  {summary}"
            echo_wrapped(line.rstrip())


def _part(kind: str, row: tuple[str, str, str]) -> dict[str, Any]:
    return {"kind": kind, **dict(zip(("name", "plugin", "summary"), row, strict=True))}


def _any(plugins: "Plugins", name: str) -> list[dict[str, Any]]:
    """Return the documentation of all parts of a name.

    Raises:
        BtManipError: If there is neither a kind nor a part of this name.
    """
    names = {kind: part_names(plugins, kind) for kind in listed(plugins)}
    found = [kind for kind in names if name in names[kind]]
    if not found:
        known = {*names, *(one for some in names.values() for one in some)}
        raise BtManipError(f"there is no kind or part '{name}'{suggestion(None, name, known)}")
    return [_described(plugins, kind, name) for kind in found]


def _list_tasks(
    plugins: "Plugins", name: str | None, robots: tuple[str, ...], episodes: int, as_json: bool
) -> None:
    """Print a line for each task and robot as it is found; check all names first."""
    from bt_manip import spatial
    from bt_manip.evaluation import why_not
    from bt_manip.runner import make_robot
    from bt_manip.scenes import SceneRobot

    parts = plugins.parts
    if name is not None:
        parts.trees.get(name)  # raises if there is none
    chosen = robots or tuple(parts.robots.names())
    for robot in robots:
        make_robot(SceneRobot(spatial.pose((0.0, 0.0, 0.0)), description=robot), parts)
    tasks = parts.trees.names() if name is None else [name]
    if name is not None and not as_json:
        _print_levels(plugins, name)
    answers = []
    widths = [max(map(len, column)) for column in (tasks, chosen)]
    for task in tasks:
        for robot in chosen:
            reason = why_not(task, robot, parts, episodes=episodes)
            answers.append({"task": task, "robot": robot, "can": not reason, "reason": reason})
            answer = f"no: {reason}" if reason else "yes"
            if not as_json:
                click.echo(f"{task:{widths[0]}}  {robot:{widths[1]}}  {answer}")
    if as_json:
        print_json(tasks=answers)


def _print_levels(plugins: "Plugins", tree: str) -> None:
    """Print the randomized quantities of a task, at each level, and the draws of its nodes."""
    from bt_manip.runner import load_source, request_of
    from bt_manip.scenes import Level, find_scene, levels_of

    parts = plugins.parts
    request = request_of(tree, parts)
    scene = find_scene(request.scene, parts)
    click.echo(f"in scene {request.scene} by itself: {Level(scene.randomization)}")
    for name, levels in levels_of(scene).items():
        for number, level in levels.items():
            click.echo(f"  {f'scene.{name}={number}':20} {level}")
    for node in load_source(request.tree, parts, {}, lambda: 0.0).nodes:
        if node.drawn:
            click.echo(f"  {node.path} draws {', '.join(node.drawn)}")


def _print_described(parts: list[dict[str, Any]]) -> None:
    """Print the documentation of parts; of several, with their kinds."""
    for part in parts:
        if len(parts) > 1:
            click.echo(f"{part['kind']}:")
        click.echo(f"{part['name']} ({part['plugin']})")
        click.echo(part["documentation"])
        for parameter in part["parameters"]:
            echo_wrapped(f"  {parameter['line']}")


def _described(plugins: "Plugins", kind: str, name: str) -> dict[str, Any]:
    """Return the documentation of one part.

    Raises:
        BtManipError: If there is no part of this name.
    """
    rows = {row[0]: row for row in _rows(plugins, kind)}
    if name not in rows:
        raise BtManipError(f"{kind}: there is no '{name}'{suggestion(None, name, rows)}")
    part: Any = None
    if kind == "behaviours":
        from bt_manip.runner import known_behaviours

        part = known_behaviours(plugins.parts).get(name)
    elif kind != "plugins":
        part = plugins.parts.by_kind()[kind].get(name)
    described = _part(kind, rows[name])
    text = inspect.cleandoc(part.__doc__ or "") if callable(part) else described["summary"]
    parameters = [
        {"name": one.name, "form": one.form, "required": one.mandatory,
         "default": one.default_text, "unit": one.unit, "line": one.line}
        for one in _parameters(kind, part).values()
    ]  # fmt: skip
    return described | {"documentation": text, "parameters": parameters}


def _parameters(kind: str, part: Any) -> "Mapping[str, Parameter]":
    """Return the declared ports or parameters of a part by name."""
    if kind == "recorders":
        return parameters_of(part, keyword_only=True)
    if isinstance(part, type) and is_dataclass(part):  # such as a fault
        return parameters_of(part)
    if kind == "objects":
        from bt_manip.cell.objects import object_parameters

        return object_parameters(part) or {}
    return getattr(part, "ports", {})


def _rows(plugins: "Plugins", kind: str) -> Iterator[tuple[str, str, str]]:
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
    if isinstance(part, str):
        return part
    if suffixes := getattr(part, "suffixes", ()):  # a model format
        return ", ".join(suffixes)
    if isinstance(summary := getattr(part, "summary", None), str):  # of a dialect
        return summary
    if not callable(part):  # such as a robot's description
        return str(getattr(part, "model", "") or getattr(part, "make", ""))
    # Not that of a base class, which getdoc() would give.
    return inspect.cleandoc(part.__doc__ or "").partition("\n")[0]
