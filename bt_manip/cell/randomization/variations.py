"""Variations as plain data, as in scene files."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from dm_control.composer import variation
from dm_control.composer.variation import distributions, noises

from bt_manip.exceptions import did_you_mean

from ..exceptions import CellError

SYNTAX = (
    "a value, or a table with one of: uniform = [low, high], integer = [low, high], "
    "normal = [mean, deviation], log_normal = [mean, sigma], choice = [value, ...], "
    "plus = (one of these), times = (one of these); 'within = [low, high]' beside it cuts off"
)
"""How a variation is written, for messages."""


class DiscreteChoice(variation.Variation):
    """One of several values, which may be vectors, with equal probability."""

    def __init__(self, values: Sequence[Any]) -> None:
        """Choose from these values."""
        self._values = list(values)

    def __call__(
        self,
        initial_value: Any = None,
        current_value: Any = None,
        random_state: np.random.RandomState | None = None,
    ) -> Any:
        """Sample a value."""
        assert random_state is not None
        return np.asarray(self._values[random_state.randint(len(self._values))], dtype=float)


class Clipped(variation.Variation):
    """Another variation, clipped to bounds."""

    def __init__(self, varied: Any, low: Any, high: Any) -> None:
        """Clip a variation."""
        self.varied, self._low, self._high = varied, low, high

    def __call__(
        self,
        initial_value: Any = None,
        current_value: Any = None,
        random_state: np.random.RandomState | None = None,
    ) -> Any:
        """Sample a value and clip it."""
        value = variation.evaluate(self.varied, initial_value, current_value, random_state)
        return np.clip(value, self._low, self._high)


def parse_variation(data: Any) -> Any:
    """Read a variation.

    Args:
        data: A number or a list of numbers, which is constant, or a table.

    Returns:
        One of composer's variations, or an array.

    Raises:
        CellError: If it is not a variation; the message has the syntax.
    """
    if not isinstance(data, Mapping):
        return _numbers(data, "a value")
    bounds = data.get("within")
    rest = {key: value for key, value in data.items() if key != "within"}
    if len(rest) != 1:
        raise CellError(f"a variation is {SYNTAX}; got {dict(data)!r}")
    ((key, arguments),) = rest.items()
    parse = _PARSERS.get(key)
    if parse is None:
        raise CellError(f"'{key}' is no variation{did_you_mean(key, _PARSERS)}; it is {SYNTAX}")
    parsed = parse(key, arguments)
    return parsed if bounds is None else Clipped(parsed, *_range("within", bounds))


def _integer(key: str, arguments: Any) -> Any:
    low, high = _range(key, arguments)
    if (low != np.round(low)).any() or (high != np.round(high)).any():
        raise CellError(f"'{key}' goes from a whole number to a whole number, got {arguments!r}")
    return distributions.UniformInteger(low.astype(int), high.astype(int) + 1)


def _choice(key: str, arguments: Any) -> Any:
    if not isinstance(arguments, list | tuple) or not arguments:
        raise CellError(f"'{key}' is a list of values, got {arguments!r}")
    values = [_numbers(value, f"'{key}'") for value in arguments]
    if len({value.shape for value in values}) != 1:
        raise CellError(f"the values of '{key}' are all alike, got {arguments!r}")
    return DiscreteChoice(values)


def _pair(key: str, arguments: Any) -> tuple[np.ndarray, np.ndarray]:
    if not isinstance(arguments, list | tuple) or len(arguments) != 2:
        raise CellError(f"'{key}' is two values, got {arguments!r}")
    first, second = (_numbers(value, f"'{key}'") for value in arguments)
    return first, second


def _range(key: str, arguments: Any) -> tuple[np.ndarray, np.ndarray]:
    low, high = _pair(key, arguments)
    if low.shape != high.shape or (low > high).any():
        raise CellError(f"'{key}' goes from low to high, got {arguments!r}")
    return low, high


def _mean_and_width(key: str, arguments: Any) -> tuple[np.ndarray, np.ndarray]:
    mean, width = _pair(key, arguments)
    if (width < 0).any():
        raise CellError(f"the second value of '{key}' is not negative, got {arguments!r}")
    return mean, width


def _numbers(data: Any, what: str) -> np.ndarray:
    try:
        numbers = np.array(data, dtype=float)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if isinstance(data, bool | str) or not np.isfinite(numbers).all():
        raise CellError(f"{what} is a number or a list of numbers, got {data!r}")
    return numbers


_PARSERS: dict[str, Callable[[str, Any], Any]] = {
    "uniform": lambda key, data: distributions.Uniform(*_range(key, data)),
    "integer": _integer,
    "normal": lambda key, data: distributions.Normal(*_mean_and_width(key, data)),
    "log_normal": lambda key, data: distributions.LogNormal(*_mean_and_width(key, data)),
    "choice": _choice,
    "plus": lambda key, data: noises.Additive(parse_variation(data)),
    "times": lambda key, data: noises.Multiplicative(parse_variation(data)),
}
