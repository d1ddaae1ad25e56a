"""Levels of a scene's randomization: how much poses, masses, lights etc. vary."""

import contextlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from bt_manip.cell.randomization import Randomization, extremes, parse_variation
from bt_manip.exceptions import BtManipError, did_you_mean

if TYPE_CHECKING:
    from .scene import Scene

VARIED_KINDS = tuple(kind.name for kind in fields(Randomization))
"""Kinds of randomized elements: ``objects``, ``robots``, ..."""

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
    """One level of a scene's randomization.

    Attributes:
        randomization: Variations; they replace the scene's variations of the same name.
        settings: Values of keys of the tree, as text; values given by the user take precedence.
    """

    randomization: Randomization = field(default_factory=Randomization)
    settings: Mapping[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        """Return the varied quantities with their bounds; ``-`` without any."""
        varies = [
            f"{thing} {quantity} {_bounds(varied)}"
            for _, thing, quantity, varied in _variations(self.randomization)
        ]
        return "; ".join([*varies, *(f"{k}={v}" for k, v in self.settings.items())]) or "-"


def levels_of(scene: "Scene") -> dict[str, dict[int, Level]]:
    """Return the levels of a scene by name and number.

    Level 0 disables the variations of the name. Level 1 has the variations of the scene itself, if
    there are any of the name. All scenes have levels of ``mass``, ``friction``, ``light`` and
    ``camera``; a scene can override these and declare others.
    """
    names = (_name(kind, quantity) for kind, _, quantity, _ in _variations(scene.randomization))
    levels: dict[str, dict[int, Level]] = {}
    for name in dict.fromkeys([*names, *scene.levels, *_GENERAL]):
        own = _selected(scene.randomization, name)
        known = {n: Level(_general(scene, name, n)) for n in _GENERAL.get(name, ())}
        known |= {1: Level(own)} if own else {}
        known |= scene.levels.get(name, {})
        if any(level.randomization for level in known.values()):
            known.setdefault(0, Level())
        levels[name] = dict(sorted(known.items()))
    return levels


def with_level(scene: "Scene", name: str, level: Any) -> tuple["Scene", Mapping[str, str]]:
    """Return a scene with a level of randomization, and the level's settings of the tree.

    Raises:
        BtManipError: If the scene has no such level.
    """
    known = levels_of(scene)
    if name not in known:
        raise BtManipError(f"scene '{scene}' has no levels of '{name}'{did_you_mean(name, known)}")
    if level not in [*known[name]] or isinstance(level, bool):
        numbers = ", ".join(map(str, known[name]))
        raise BtManipError(f"scene '{scene}' has the levels {numbers} of {name}, got {level}")
    chosen = known[name][int(level)]
    rest = _selected(scene.randomization, name, inverse=True)
    joined = _gathered([*_variations(rest), *_variations(chosen.randomization)])
    return replace(scene, randomization=joined), chosen.settings


def _name(kind: str, quantity: str) -> str:
    """Return the name of the levels to which a quantity belongs."""
    if kind == "objects":
        return _OF_QUANTITY.get(quantity, "size")
    return _OF_KIND.get(kind, kind)


def _variations(randomization: Randomization) -> Iterator[tuple[str, str, str, Any]]:
    """Yield kind, name, quantity and variation of each varied quantity."""
    for kind in VARIED_KINDS:
        for name, varied in getattr(randomization, kind).items():
            for quantity, variation in varied.items():
                yield kind, name, quantity, variation


def _gathered(variations: Iterable[tuple[str, str, str, Any]]) -> Randomization:
    """Return a randomization of variations; the last one of each quantity counts."""
    gathered: dict[str, dict[str, dict[str, Any]]] = {}
    for kind, name, quantity, variation in variations:
        gathered.setdefault(kind, {}).setdefault(name, {})[quantity] = variation
    return Randomization(**gathered)


def _selected(randomization: Randomization, name: str, *, inverse: bool = False) -> Randomization:
    """Return the variations that belong to a name, or with `inverse` all others."""
    return _gathered(
        (kind, *rest, quantity, variation)
        for kind, *rest, quantity, variation in _variations(randomization)
        if (_name(kind, quantity) == name) is not inverse
    )


def _general(scene: "Scene", name: str, level: int) -> Randomization:
    """Return the variations of a level that all scenes have."""
    varied = {key: parse_variation(data) for key, data in _GENERAL[name][level].items()}
    if name == "light":
        return Randomization(lights={"key": varied, "fill": varied})
    if name == "camera":
        own = [camera.name for camera in scene.objects if camera.model == "camera"]
        return Randomization(cameras=dict.fromkeys(("overview", *own), varied))
    return Randomization(objects={"*": varied})


def _bounds(varied: Any) -> str:
    """Return the bounds of a variation: of the value, of a factor, or of an increment."""
    at_zero: list[Any] = []
    for shape in ((), 2, 3):  # a number, x and y, a position or a colour
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
