"""Variations: parsing from plain data, as in scene files, and sampling."""

import contextlib
import hashlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from dm_control.composer import variation
from dm_control.composer.variation import distributions, noises

from bt_manip.exceptions import did_you_mean, shown
from bt_manip.spatial import as_numbers

from ..exceptions import CellError

Varied = Any
"""One of composer's variations, or a constant."""

SYNTAX = (
    "a value, or a table with one of: uniform = [low, high], integer = [low, high], "
    "normal = [mean, deviation], log_normal = [mean, sigma], choice = [value, ...], "
    "plus = (one of these), times = (one of these); 'within = [low, high]' beside it clips"
)
"""Syntax of a variation, for messages."""


MAX_INTEGER = 2**31 - 1

DEVIATIONS = 6.0
"""Bound of possible normal samples in standard deviations: all but 2 in 10^9."""


class Extreme:
    """A random state whose samples are the smallest or largest possible.

    It has the methods of ``numpy.random.RandomState`` used by composer's distributions.

    Args:
        largest: Whether samples are the largest possible.
    """

    def __init__(self, *, largest: bool) -> None:
        self._largest = largest

    def uniform(self, low: Any, high: Any, size: Any = None) -> Any:
        """Return a bound."""
        return self._sized(high if self._largest else low, size)

    def randint(self, low: Any, high: Any, size: Any = None) -> Any:
        """Return a bound of integers; the given upper bound is exclusive."""
        return self._sized(np.asarray(high) - 1 if self._largest else low, size)

    def normal(self, loc: Any = 0.0, scale: Any = 1.0, size: Any = None) -> Any:
        """Return the mean minus or plus `DEVIATIONS` standard deviations."""
        sign = 1.0 if self._largest else -1.0
        return self._sized(loc + sign * DEVIATIONS * np.asarray(scale), size)

    def lognormal(self, mean: Any, sigma: Any, size: Any = None) -> Any:
        """Return the exponential of a normal sample."""
        with np.errstate(over="ignore"):
            return np.exp(self.normal(mean, sigma, size))

    def of(self, values: Sequence[np.ndarray]) -> np.ndarray:
        """Return the element-wise minimum or maximum of values."""
        return (np.max if self._largest else np.min)(values, axis=0)

    @staticmethod
    def _sized(value: Any, size: Any) -> Any:
        return value if size is None else np.broadcast_to(value, size)


def extremes(varied: Varied, nominal: Any) -> list[Any]:
    """Return the smallest and largest sample of a variation, if its distribution is known.

    Args:
        varied: The variation.
        nominal: The value without variation: a number or an array.

    Raises:
        ValueError: If the shapes of the variation and of the nominal value differ.
    """
    found = []
    for largest in (False, True):
        with contextlib.suppress(AttributeError):  # an unknown distribution, from Python code
            found.append(sample(varied, nominal, Extreme(largest=largest)))
    return found


class Clipped(variation.Variation):
    """A variation clipped to bounds."""

    def __init__(self, varied: Any, low: Any, high: Any) -> None:
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
    """Parse a variation.

    Args:
        data: A number or a list of numbers, for a constant, or a table.

    Returns:
        One of composer's variations, or an array.

    Raises:
        CellError: If it is invalid; the message has the syntax.
    """
    if not isinstance(data, Mapping):
        return _numbers(data, "a value")
    bounds = data.get("within")
    rest = {key: value for key, value in data.items() if key != "within"}
    if len(rest) != 1:
        raise CellError(f"a variation is {SYNTAX}; got {dict(data)!r}")
    ((key, arguments),) = rest.items()
    parse = PARSERS.get(key)
    if parse is None:
        raise CellError(f"'{key}' is no variation{did_you_mean(key, PARSERS)}; it is {SYNTAX}")
    parsed = parse(key, arguments)
    return parsed if bounds is None else Clipped(parsed, *_range("within", bounds))


def _integer(key: str, arguments: Any) -> Any:
    low, high = _range(key, arguments)
    if max(np.abs(low).max(), np.abs(high).max()) > MAX_INTEGER:
        raise CellError(f"'{key}' goes up to {MAX_INTEGER}, got {shown(arguments)}")
    if (low != np.round(low)).any() or (high != np.round(high)).any():
        raise CellError(f"'{key}' is a range of whole numbers, got {arguments!r}")
    return distributions.UniformInteger(low.astype(int), high.astype(int) + 1)


def _choice(key: str, arguments: Any) -> Any:
    if not isinstance(arguments, list | tuple) or not arguments:
        raise CellError(f"'{key}' is a list of values, got {arguments!r}")
    values = [_numbers(value, f"'{key}'") for value in arguments]
    if len({value.shape for value in values}) != 1:
        raise CellError(f"the values of '{key}' must have the same shape, got {arguments!r}")

    def choose(initial_value: Any, current_value: Any, random_state: Any) -> Any:
        if isinstance(random_state, Extreme):
            return random_state.of(values)
        return values[random_state.randint(len(values))]

    return choose


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
    numbers = as_numbers(data)
    if not np.isfinite(numbers).all():
        raise CellError(f"{what} is a number or a list of numbers, got {data!r}")
    return numbers


PARSERS: dict[str, Callable[[str, Any], Any]] = {
    "uniform": lambda key, data: distributions.Uniform(*_range(key, data)),
    "integer": _integer,
    "normal": lambda key, data: distributions.Normal(*_mean_and_width(key, data)),
    "log_normal": lambda key, data: distributions.LogNormal(*_mean_and_width(key, data)),
    "choice": _choice,
    "plus": lambda key, data: noises.Additive(parse_variation(data)),
    "times": lambda key, data: noises.Multiplicative(parse_variation(data)),
}


def stream(seed: int, cycle: int, *key: str | int) -> np.random.RandomState:
    """Return the random stream of one value in one cycle of a run.

    It depends neither on other varied values nor on earlier samples.

    Args:
        seed: Seed of the run.
        cycle: Number of the cycle.
        key: Names of the value.
    """
    return np.random.RandomState(np.random.MT19937(_sequence(seed, cycle, key)))


def generator(seed: int, *key: str | int) -> np.random.Generator:
    """Return the random generator of values sampled once, before the first cycle.

    Args:
        seed: Seed of the run.
        key: Names of the values.
    """
    return np.random.Generator(np.random.PCG64(_sequence(seed, 0, ("at first", *key))))


def _sequence(seed: int, cycle: int, key: tuple[str | int, ...]) -> np.random.SeedSequence:
    digest = hashlib.sha256("\0".join(map(str, key)).encode()).digest()
    words = np.frombuffer(digest, "<u4").tolist()
    return np.random.SeedSequence(seed, spawn_key=(cycle, *words))


def sample(varied: Varied, nominal: Any, random_state: np.random.RandomState | Extreme) -> Any:
    """Sample a value as plain data: a number or a list of numbers.

    Args:
        varied: The variation; composer's variations are given the nominal value.
        nominal: The value without variation: a number or an array.
        random_state: The random stream.
    """
    value = variation.evaluate(varied, nominal, nominal, random_state)
    numbers = np.asarray(value)
    return numbers.astype(int if numbers.dtype.kind in "iu" else float).tolist()
