"""Varied parameters of tree, controller, scene and robot, applied to a request and its parts."""

import inspect
import json
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, is_dataclass, replace
from functools import partial
from typing import Any

from bt_manip.cell.randomization import Randomization
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts
from bt_manip.scenes import Scene, find_robot, find_scene, with_level

from .request import RunRequest

CHOSEN = ("robot", "controller", "scene", "planner")
"""Parameters that choose a part of the station."""


def with_varied(request: RunRequest, parts: Parts) -> tuple[RunRequest, Parts]:
    """Return a request and parts with the values of the request's varied parameters."""
    point = request.varied
    chosen: dict[str, Any] = {name: str(point[name]) for name in CHOSEN if name in point}
    keys = {k: _text(v) for k, v in point.items() if k not in chosen and "." not in k}
    request = replace(request, settings={**request.settings, **keys}, **chosen)
    scene = before = find_scene(request.scene, parts)
    for name, value in point.items():
        owner, dot, path = name.partition(".")
        if not dot:
            continue
        if owner == "controller":
            parts = _with_controllers(request, scene, parts, path, value)
        elif owner == "scene" and "." not in path:
            scene, settings = with_level(scene, path, value)
            request = replace(request, settings={**settings, **request.settings})
        elif owner == "scene":
            scene = _with_variation(scene, name, path, value)
        elif owner == "robot":
            scene = _with_robots(request, scene, parts, path.split("."), value)
        else:
            near = did_you_mean(owner, ("controller", "scene", "robot"))
            raise BtManipError(f"nothing is called '{name}'{near}")
    if scene is not before:
        request = replace(request, scene=scene)
    return request, parts


def _text(value: Any) -> str:
    return value if isinstance(value, str) else json.dumps(value)


def _with_controllers(
    request: RunRequest, scene: Scene, parts: Parts, key: str, value: Any
) -> Parts:
    """Set a parameter of the controllers that the robots begin with."""
    controllers = parts.controllers
    for name in dict.fromkeys(one.controller or request.controller for one in scene.robots):
        factory: Callable[..., Any] = controllers.get(name)
        made = getattr(factory, "func", factory)  # of another varied parameter
        signature = inspect.signature(getattr(made, "_build", made))
        known = [n for n, one in signature.parameters.items() if one.default is not one.empty]
        if key not in known:
            raise BtManipError(f"controller '{name}' has no '{key}'{did_you_mean(key, known)}")
        controllers = controllers.with_part(name, partial(factory, **{key: value}))
    return replace(parts, controllers=controllers)


def _with_variation(scene: Scene, name: str, path: str, value: Any) -> Scene:
    """Set a quantity of the randomization to a constant."""
    kinds = [one.name for one in fields(Randomization)]
    kind, _, rest = path.partition(".")
    thing, _, quantity = rest.rpartition(".")
    if kind not in kinds or not thing:
        raise BtManipError(
            f"'{name}' is no parameter of a scene: they are called scene.KIND.NAME.QUANTITY, "
            f"or scene.NAME for a level, where KIND is one of {', '.join(kinds)}"
        )
    variations = getattr(scene.randomization, kind)
    changed = {**variations, thing: {**variations.get(thing, {}), quantity: value}}
    return replace(scene, randomization=replace(scene.randomization, **{kind: changed}))


def _with_robots(
    request: RunRequest, scene: Scene, parts: Parts, path: list[str], value: Any
) -> Scene:
    """Set a field of the descriptions of all robots."""
    robots = []
    for one in scene.robots:
        description = find_robot(one.description or request.robot, parts.robots)
        changed = _with_field(description, path, value, f"robot '{description.name}'")
        robots.append(replace(one, description=changed))
    return replace(scene, robots=tuple(robots))


def _with_field(owner: Any, path: Iterable[str], value: Any, where: str) -> Any:
    """Return a copy with another value of a field; a number is a factor of a list of numbers."""
    key, *rest = path
    known = [one.name for one in fields(owner)] if is_dataclass(owner) else list(owner or ())
    if key not in known:
        raise BtManipError(f"{where} has no '{key}'{did_you_mean(key, known)}")
    old = getattr(owner, key) if is_dataclass(owner) else owner[key]
    if rest:
        new = _with_field(old, rest, value, f"{where}: {key}")
    elif isinstance(old, tuple) and isinstance(value, int | float):
        new = tuple(value * one for one in old)
    else:
        new = tuple(value) if isinstance(old, tuple) else value
    return {**owner, key: new} if isinstance(owner, Mapping) else replace(owner, **{key: new})
