"""Variations as plain data, as they stand in files."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from dm_control.composer import variation
from dm_control.composer.variation import distributions, noises

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError

WAYS = (
    "a value, or a table with one of: uniform = [low, high], integer = [low, high], "
    "normal = [mean, deviation], log_normal = [mean, sigma], choice = [value, ...], "
    "plus = (one of these), times = (one of these); 'within = [low, high]' beside it cuts off"
)
"""How a variation is written, to end the sentence "a variation is"."""


class OneOf(variation.Variation):
    """One of several values, which may be vectors."""

    def __init__(self, values: Sequence[Any]) -> None:
        """Know the values."""
        self._values = list(values)

    def __call__(
        self,
        initial_value: Any = None,
        current_value: Any = None,
        random_state: np.random.RandomState | None = None,
    ) -> Any:
        """Draw one, each as likely as the others."""
        assert random_state is not None
        return np.asarray(self._values[random_state.randint(len(self._values))], dtype=float)


class Within(variation.Variation):
    """What another variation gives, cut off at bounds."""

    def __init__(self, varied: Any, low: Any, high: Any) -> None:
        """Know the variation and its bounds."""
        self.varied, self._low, self._high = varied, low, high

    def __call__(
        self,
        initial_value: Any = None,
        current_value: Any = None,
        random_state: np.random.RandomState | None = None,
    ) -> Any:
        """Draw, and cut off."""
        value = variation.evaluate(self.varied, initial_value, current_value, random_state)
        return np.clip(value, self._low, self._high)


def parse_variation(data: Any) -> Any:
    """Read a variation.

    Args:
        data: A number or a list of numbers, which is always the same, or a table.

    Returns:
        One of composer's variations, or an array.

    Raises:
        CellError: When it is none; says how one is written.
    """
    if not isinstance(data, Mapping):
        return _numbers(data, "a value")
    bounds = data.get("within")
    rest = {key: value for key, value in data.items() if key != "within"}
    if len(rest) != 1:
        raise CellError(f"a variation is {WAYS}; got {dict(data)!r}")
    ((way, arguments),) = rest.items()
    make = _MAKERS.get(way)
    if make is None:
        raise CellError(f"'{way}' is no variation{did_you_mean(way, _MAKERS)}; it is {WAYS}")
    made = make(way, arguments)
    return made if bounds is None else Within(made, *_range("within", bounds))


def _uniform(way: str, arguments: Any) -> Any:
    return distributions.Uniform(*_range(way, arguments))


def _integer(way: str, arguments: Any) -> Any:
    low, high = _range(way, arguments)
    if (low != np.round(low)).any() or (high != np.round(high)).any():
        raise CellError(f"'{way}' goes from a whole number to a whole number, got {arguments!r}")
    return distributions.UniformInteger(low.astype(int), high.astype(int) + 1)


def _normal(way: str, arguments: Any) -> Any:
    return distributions.Normal(*_centre_and_width(way, arguments))


def _log_normal(way: str, arguments: Any) -> Any:
    return distributions.LogNormal(*_centre_and_width(way, arguments))


def _choice(way: str, arguments: Any) -> Any:
    if not isinstance(arguments, list | tuple) or not arguments:
        raise CellError(f"'{way}' is a list of values, got {arguments!r}")
    values = [_numbers(value, f"'{way}'") for value in arguments]
    if len({value.shape for value in values}) != 1:
        raise CellError(f"the values of '{way}' are all alike, got {arguments!r}")
    return OneOf(values)


def _plus(way: str, arguments: Any) -> Any:
    return noises.Additive(parse_variation(arguments))


def _times(way: str, arguments: Any) -> Any:
    return noises.Multiplicative(parse_variation(arguments))


_MAKERS: dict[str, Callable[[str, Any], Any]] = {
    "uniform": _uniform,
    "integer": _integer,
    "normal": _normal,
    "log_normal": _log_normal,
    "choice": _choice,
    "plus": _plus,
    "times": _times,
}


def _pair(way: str, arguments: Any) -> tuple[np.ndarray, np.ndarray]:
    if not isinstance(arguments, list | tuple) or len(arguments) != 2:
        raise CellError(f"'{way}' is two values, got {arguments!r}")
    first, second = (_numbers(value, f"'{way}'") for value in arguments)
    return first, second


def _range(way: str, arguments: Any) -> tuple[np.ndarray, np.ndarray]:
    low, high = _pair(way, arguments)
    if low.shape != high.shape or (low > high).any():
        raise CellError(f"'{way}' goes from low to high, got {arguments!r}")
    return low, high


def _centre_and_width(way: str, arguments: Any) -> tuple[np.ndarray, np.ndarray]:
    centre, width = _pair(way, arguments)
    if (width < 0).any():
        raise CellError(f"the second value of '{way}' is not negative, got {arguments!r}")
    return centre, width


def _numbers(data: Any, what: str) -> np.ndarray:
    try:
        numbers = np.array(data, dtype=float)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if isinstance(data, bool | str) or not np.isfinite(numbers).all():
        raise CellError(f"{what} is a number or a list of numbers, got {data!r}")
    return numbers
