"""``bt-manip scene``: check and show scenes."""

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import click

from bt_manip.cli.completion import complete_part
from bt_manip.cli.exit_codes import BAD_INPUT, SUCCESS
from bt_manip.cli.json_output import findings_of, json_option, print_json
from bt_manip.cli.plugin_group import PluginGroup
from bt_manip.cli.plugin_options import load_chosen_plugins
from bt_manip.cli.streams import echo_wrapped
from bt_manip.exceptions import BtManipError, with_short_values
from bt_manip.registry import Parts

if TYPE_CHECKING:
    from bt_manip.bt import Problem
    from bt_manip.cell import Cell
    from bt_manip.runner import Station
    from bt_manip.scenes import Scene

_robot = click.option(
    "--robot", default="panda", show_default=True, metavar="R",
    shell_complete=complete_part("robots"),
    help="Robot of scenes that do not name one: a registered name, or path.toml.",
)  # fmt: skip


@click.group(cls=PluginGroup)
def scene() -> None:
    """Check and show scenes: the robots and objects that a run starts with."""
    os.environ.setdefault("MUJOCO_GL", "disable")


@scene.command()
@click.argument(
    "files", nargs=-1, required=True, metavar="SCENE...", shell_complete=complete_part("scenes")
)
@_robot
@json_option
def check(files: tuple[str, ...], robot: str, as_json: bool) -> int:
    """Print all errors of scenes, each with file, line and key.

    SCENE is path.toml or a registered name. Valid scenes are also built, which finds objects that
    overlap. Exits with 2 if there are errors.
    """
    parts = load_chosen_plugins().parts
    found: list[Problem] = []
    for text in files:
        problems = [with_short_values(one) for one in _problems(text, parts, robot)]
        found += findings_of(problems, text)
        for problem in () if as_json else problems:
            click.echo(problem)
    if as_json:
        print_json(found)
    else:
        scenes = f"{len(files)} scene{'s' if len(files) != 1 else ''}"
        click.echo(f"{scenes}: {len(found)} error{'s' if len(found) != 1 else ''}", err=True)
    return BAD_INPUT if found else SUCCESS


def _problems(text: str, parts: Parts, robot: str) -> tuple[str, ...]:
    from bt_manip.scenes import SceneError

    try:
        _, station = _built(text, parts, robot, drawn=True)
        for warning in station.model_warnings():
            click.echo(f"Warning: {warning}", err=True)
    except SceneError as error:
        return error.problems
    except BtManipError as error:
        return (str(error),)
    return ()


@scene.command()
@click.argument("name", metavar="SCENE", shell_complete=complete_part("scenes"))
@_robot
def show(name: str, robot: str) -> None:
    """Print the robots and objects of a scene with their poses, and what varies between cycles.

    SCENE is path.toml or a registered name.
    """
    found, station = _built(name, load_chosen_plugins().parts, robot)
    for line in _lines(found, station):
        echo_wrapped(line)


def _built(
    text: str, parts: Parts, robot: str, *, drawn: bool = False
) -> tuple["Scene", "Station"]:
    """Return a scene and its station, before or after the randomization of the first cycle."""
    from bt_manip.plugins import build_station
    from bt_manip.scenes import find_scene, naming_file, seed_of

    found = find_scene(text, parts)
    station = build_station(parts, robot=robot, scene=found, seed=seed_of(text, parts))
    if drawn:
        with naming_file(found):
            station.randomizer.begin(0)
    return found, station


def _lines(found: "Scene", station: "Station") -> Iterator[str]:
    if found.about:
        yield found.about
    if found.seed is not None:
        yield f"seed {found.seed}"
    yield "robots:"
    for robot, (name, commanded) in zip(found.robots, station.robots.items(), strict=True):
        what = robot.description or commanded.robot.description.name
        extra = [part for part in (robot.controller, robot.planner) if part]
        with_parts = f", {', '.join(extra)}" if extra else ""
        yield f"  {name}: {what}{with_parts}, {_place(station.cell, name)}"
    if found.objects:
        yield "objects:"
    for scene_object in found.objects:
        entity = station.cell.entities[scene_object.name]
        placed = _place(station.cell, scene_object.name)
        on = f", on '{scene_object.on}'" if scene_object.on else ""
        drawn = ", pose sampled from the seed" if scene_object.region else ""
        yield f"  {scene_object.name}: {scene_object.model}{_facts(entity)}, {placed}{on}{drawn}"
    if found.randomization:
        yield "varies from cycle to cycle, in the first one:"
        yield from _varied(found, station)


def _facts(entity: Any) -> str:
    from bt_manip.cell import as_object

    declared = as_object(entity)
    facts = [declared.category]
    if declared.mass:
        facts.append(f"{declared.mass:.3g} kg")
    return f" ({', '.join(fact for fact in facts if fact)})"


def _place(cell: "Cell", name: str) -> str:
    import pinocchio as pin

    T = cell.pose(name)
    x, y, z = T.translation
    turns = [f"{angle:.3f}" for angle in pin.rpy.matrixToRpy(T.rotation) + 0.0]
    turned = f", turned by {' '.join(turns)} rad" if any(abs(float(t)) > 0 for t in turns) else ""
    return f"at {x:.3f} {y:.3f} {z:.3f} m{turned}"


def _varied(found: "Scene", station: "Station") -> Iterator[str]:
    """Yield the variations, with the values of the first cycle if they are known."""
    from bt_manip.scenes import naming_file

    with naming_file(found):
        station.randomizer.begin(0)
    drawn = station.randomizer.sampled
    for where in ("objects", "robots", "lights", "cameras", "observations"):
        for thing, lines in getattr(found.randomization, where).items():
            values = drawn.get(where, {}).get(thing, {})
            facts = [f"{name} {_brief(values[name])}" if name in values else name for name in lines]
            yield f"  {where} {thing}: {', '.join(facts)}"


def _brief(value: Any) -> str:
    return " ".join(f"{number:.4g}" for number in (value if isinstance(value, list) else [value]))
