"""Levels of a scene's randomization: how strongly its starts vary, by name."""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.cell.randomization import Randomization, extremes, parse_variation
from bt_manip.exceptions import BtManipError, did_you_mean

if TYPE_CHECKING:
    from .scene import Scene

VARIED_KINDS = tuple(one.name for one in fields(Randomization))
"""Kinds of things that vary: ``objects``, ``robots``, ..."""

_OF_KIND = {"lights": "light", "cameras": "camera"}
_OF_QUANTITY = {
    "position": "pose", "yaw": "pose", "mass": "mass", "friction": "friction",
    "colour": "colour", "gain": "gain",
}  # fmt: skip
_GENERAL: Mapping[str, Mapping[int, Mapping[str, Any]]] = {
    "mass": {
        1: {"mass": {"times": {"uniform": [0.8, 1.2]}}},
        2: {"mass": {"times": {"uniform": [0.5, 2.0]}}},
    },
    "friction": {
        1: {"friction": {"times": {"uniform": [0.9, 1.1]}}},
        2: {"friction": {"times": {"uniform": [0.7, 1.3]}}},
    },
    "light": {
        1: {
            "brightness": {"uniform": [0.8, 1.2]},
            "direction": {"plus": {"uniform": [-0.1, 0.1]}},
        },
        2: {
            "brightness": {"uniform": [0.4, 1.6]},
            "direction": {"plus": {"uniform": [-0.4, 0.4]}},
        },
    },
    "camera": {
        1: {
            "position": {"plus": {"uniform": [-0.01, 0.01]}},
            "rotation": {"uniform": [-0.01, 0.01]},
        },
        2: {
            "position": {"plus": {"uniform": [-0.05, 0.05]}},
            "rotation": {"uniform": [-0.05, 0.05]},
            "fovy": {"times": {"uniform": [0.9, 1.1]}},
        },
    },
}


@dataclass(frozen=True)
class Level:
    """What varies at a level.

    Attributes:
        randomization: Variations, in place of those of the scene that have the same name.
        settings: Values of keys of the tree, as text; given ones are kept.
    """

    randomization: Randomization = field(default_factory=Randomization)
    settings: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        """Return the quantities that vary, with their bounds; ``-`` if none does."""
        varies = [
            f"{thing} {quantity} {_bounds(varied)}"
            for _, thing, quantity, varied in _variations(self.randomization)
        ]
        return "; ".join([*varies, *(f"{k}={v}" for k, v in self.settings.items())]) or "-"


def levels_of(scene: "Scene") -> dict[str, dict[int, Level]]:
    """Return the levels of a scene by name and number.

    At level 0 nothing of the name varies. Level 1 is what varies in the scene by itself, if that is
    anything of the name. ``mass``, ``friction``, ``light`` and ``camera`` have levels in all
    scenes; others, and others of these, are those that the scene declares.
    """
    names = (_name(kind, quantity) for kind, _, quantity, _ in _variations(scene.randomization))
    found: dict[str, dict[int, Level]] = {}
    for name in dict.fromkeys([*names, *scene.levels, *_GENERAL]):
        own = _selected(scene.randomization, name)
        known = {n: Level(_general(scene, name, n)) for n in _GENERAL.get(name, ())}
        known |= {1: Level(own)} if own else {}
        known |= scene.levels.get(name, {})
        if any(level.randomization for level in known.values()):
            known.setdefault(0, Level())
        found[name] = dict(sorted(known.items()))
    return found


def with_level(scene: "Scene", name: str, level: Any) -> tuple["Scene", Mapping[str, str]]:
    """Return a scene whose randomization has a level, and the settings of the tree that it takes.

    Args:
        scene: The scene.
        name: What varies: ``pose``, ``mass``, ...
        level: The number of the level.

    Raises:
        BtManipError: If the scene has no such level.
    """
    known = levels_of(scene)
    if name not in known:
        near = did_you_mean(name, known)
        raise BtManipError(f"scene '{scene}' has no levels of '{name}'{near}; {', '.join(known)}")
    if level not in [*known[name]] or isinstance(level, bool):
        numbers = ", ".join(map(str, known[name]))
        raise BtManipError(f"scene '{scene}' has the levels {numbers} of {name}, got {level}")
    chosen = known[name][int(level)]
    rest = _selected(scene.randomization, name, inverse=True)
    joined = _gathered([*_variations(rest), *_variations(chosen.randomization)])
    return replace(scene, randomization=joined), chosen.settings


def _name(kind: str, quantity: str) -> str:
    """Return the name of the levels that a quantity belongs to."""
    if kind == "objects":
        return _OF_QUANTITY.get(quantity, "size")
    return _OF_KIND.get(kind, kind)


def _variations(randomization: Randomization) -> Iterator[tuple[str, str, str, Any]]:
    """Yield kind and name of the thing, quantity and variation of all that varies."""
    for kind in VARIED_KINDS:
        for thing, found in getattr(randomization, kind).items():
            for quantity, varied in found.items():
                yield kind, thing, quantity, varied


def _gathered(variations: Iterable[tuple[str, str, str, Any]]) -> Randomization:
    """Return the randomization of variations; of several of one quantity, the last."""
    found: dict[str, dict[str, dict[str, Any]]] = {}
    for kind, thing, quantity, varied in variations:
        found.setdefault(kind, {}).setdefault(thing, {})[quantity] = varied
    return Randomization(**found)


def _selected(randomization: Randomization, name: str, *, inverse: bool = False) -> Randomization:
    """Return the variations of a name, or all others."""
    found = _variations(randomization)
    return _gathered(one for one in found if (_name(one[0], one[2]) == name) is not inverse)


def _general(scene: "Scene", name: str, level: int) -> Randomization:
    """Return a level that all scenes have."""
    varied = {key: parse_variation(data) for key, data in _GENERAL[name][level].items()}
    if name == "light":
        return Randomization(lights={"key": varied, "fill": varied})
    if name == "camera":
        own = [one.name for one in scene.fixtures if one.model == "camera"]
        return Randomization(cameras=dict.fromkeys(("overview", *own), varied))
    return Randomization(objects={"*": varied})


def _bounds(varied: Any) -> str:
    """Return the bounds of a variation: of the value, of a factor, or of what is added to it."""
    at_zero: list[Any] = []
    for shape in ((), 2, 3):  # a number, two of a plane, three of a position or a colour
        with contextlib.suppress(ValueError):
            at_zero, at_one = (extremes(varied, np.full(shape, value)) for value in (0.0, 1.0))
            break
    if len(at_zero) < 2:
        return "by a distribution"
    word, bounds = "", at_zero
    if not np.array_equal(at_zero, at_one):
        word, bounds = ("plus ", at_zero) if np.any(at_zero) else ("times ", at_one)
    low, high = (
        " ".join(f"{number:.4g}" for number in np.atleast_1d(bound).ravel()) for bound in bounds
    )
    return f"{word}{low}" if low == high else f"{word}{low} to {high}"
