"""Values of varied parameters: single ones, on a grid, or sampled."""

import itertools
import json
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bt_manip.exceptions import BtManipError
from bt_manip.runner import ParameterSet


@dataclass(frozen=True)
class VariedParameter:
    """A parameter and its values.

    Attributes:
        name: A key of the tree; one of `bt_manip.runner.CHOSEN`; or, with dots, a parameter of the
            controller (``controller.kp``), of something in the scene
            (``scene.objects.cube.mass``), a level of its randomization (``scene.mass``), or of the
            robot's description (``robot.gripper.max_force``).
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

    Values are JSON (numbers, lists, texts in quotes) or plain texts without commas. Other texts
    raise a `BtManipError`.
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
    """Return all combinations of values; ranges need a number of values."""
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

    Parameters with bounds are sampled from the whole range.
    """
    rng = np.random.default_rng(seed)
    quantiles = [(rng.permutation(n) + rng.uniform(size=n)) / n for _ in parameters]
    pairs = list(zip(parameters, quantiles, strict=True))
    return tuple({one.name: one.at(float(q[i])) for one, q in pairs} for i in range(n))
