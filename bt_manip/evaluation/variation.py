"""Varied parameters of tree, controller, scene and robot: on a grid, or sampled."""

import inspect
import itertools
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from bt_manip.cell.randomization import Randomization
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts
from bt_manip.runner import RunRequest
from bt_manip.scenes import Scene, find_robot, find_scene, with_level

ParameterSet = Mapping[str, Any]
"""Values of the varied parameters, by name."""

CHOSEN = ("robot", "controller", "scene", "planner")
"""Parameters that choose a part of the station."""


@dataclass(frozen=True)
class VariedParameter:
    """A parameter and its values.

    Attributes:
        name: A key of the tree; one of `CHOSEN`; or, with dots, a parameter of the controller
            (``controller.kp``), of something in the scene (``scene.objects.cube.mass``), a level of
            its randomization (``scene.mass``), or of the robot's description
            (``robot.gripper.max_force``).
        values: The values, for a grid and to sample from.
        bounds: Lowest and highest value of a range; None for single values.
    """

    name: str
    values: tuple[Any, ...] = ()
    bounds: tuple[float, float] | None = None

    def at(self, quantile: float) -> Any:
        """Return the value at a quantile, from 0 up to but not including 1."""
        if self.bounds is not None:
            low, high = self.bounds
            return low + quantile * (high - low)
        return self.values[int(quantile * len(self.values))]


def parse_parameter(text: str) -> VariedParameter:
    """Read ``KEY=VALUE,VALUE,...``, ``KEY=LOW..HIGH`` or ``KEY=LOW..HIGH:COUNT``.

    Values are JSON (numbers, lists, texts in quotes) or plain texts without commas.

    Raises:
        BtManipError: If it is none of these.
    """
    name, equals, given = (part.strip() for part in text.partition("="))
    if not equals or not name or not given:
        raise BtManipError(f"--vary is KEY=VALUE,VALUE,... or KEY=LOW..HIGH, got '{text}'")
    low, dots, rest = given.partition("..")
    high, colon, count = rest.partition(":")
    try:
        if dots:
            bounds = float(low), float(high)
            values = np.linspace(*bounds, int(count)).tolist() if colon else []
            return VariedParameter(name, tuple(values), bounds)
    except ValueError:
        raise BtManipError(f"--vary {name}: '{given}' is no range LOW..HIGH:COUNT") from None
    try:
        return VariedParameter(name, tuple(json.loads(f"[{given}]")))
    except ValueError:
        return VariedParameter(name, tuple(one.strip() for one in given.split(",")))


def parse_point(texts: Iterable[str]) -> ParameterSet:
    """Read parameters that have one value each.

    Raises:
        BtManipError: If one has several, or cannot be read.
    """
    parameters = [parse_parameter(text) for text in texts]
    for one in parameters:
        if len(one.values) != 1:
            raise BtManipError(f"--vary {one.name}: a run has one value, see bt-manip sweep")
    return {one.name: one.values[0] for one in parameters}


def grid(parameters: Sequence[VariedParameter]) -> tuple[ParameterSet, ...]:
    """Return all combinations of values.

    Raises:
        BtManipError: If a range has no number of values.
    """
    for one in parameters:
        if not one.values:
            raise BtManipError(
                f"--vary {one.name}: on a grid, a range needs its number of values, as in "
                "LOW..HIGH:5; or give --samples"
            )
    names = [one.name for one in parameters]
    combinations = itertools.product(*(one.values for one in parameters))
    return tuple(dict(zip(names, values, strict=True)) for values in combinations)


def samples(parameters: Sequence[VariedParameter], n: int, seed: int) -> tuple[ParameterSet, ...]:
    """Sample points by Latin hypercube sampling (McKay, Beckman and Conover 1979).

    Args:
        parameters: The parameters; those with bounds are sampled from the whole range.
        n: Number of points.
        seed: Seed of the samples.
    """
    rng = np.random.default_rng(seed)
    quantiles = [(rng.permutation(n) + rng.uniform(size=n)) / n for _ in parameters]
    pairs = list(zip(parameters, quantiles, strict=True))
    return tuple({one.name: one.at(float(q[i])) for one, q in pairs} for i in range(n))


def varied(request: RunRequest, parts: Parts, point: ParameterSet) -> tuple[RunRequest, Parts]:
    """Return a request and parts with the values of a point.

    Raises:
        BtManipError: If there is no such parameter.
    """
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
        known = inspect.signature(getattr(made, "_build", made)).parameters
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
