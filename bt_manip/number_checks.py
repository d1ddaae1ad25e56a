"""Refuse what is no number, no list of numbers and no source of them."""

from math import inf, isfinite
from typing import Any

import numpy as np

from bt_manip.exceptions import MotionError

_FLOAT = np.dtype(float)
_LONGEST = 120  # letters of what was found that an error shows


def check_amount(amount: Any, what: str, unit: str = "") -> float:
    """Give a length or an angle as a number.

    Args:
        amount: 0 or above.
        what: How the error calls it.
        unit: Its unit, where it has one.

    Raises:
        MotionError: When it is not a finite number, or below 0.
    """
    if type(amount) is float and 0.0 <= amount < inf:
        return amount
    number = as_numbers(amount)
    if number.shape != () or not 0.0 <= number < inf:
        unit = unit and f" [{unit}]"
        raise MotionError(f"{what} is 0 or above{unit}, got {shown(amount)}", reason="target")
    return float(number)


def positive(number: Any) -> bool:
    """Tell whether something is a single finite number above 0."""
    try:
        single = getattr(number, "ndim", 0) == 0 and number is not True
        return single and isfinite(number) and bool(number > 0.0)
    except (TypeError, ValueError, OverflowError):
        return False


def check_positive(number: Any, what: str, unit: str = "") -> float:
    """Give a number above 0.

    Args:
        number: The number.
        what: How the error calls it.
        unit: Its unit, where it has one.

    Raises:
        MotionError: When it is not a finite number, or not above 0.
    """
    if not positive(number):
        unit = unit and f" [{unit}]"
        raise MotionError(f"{what} is above 0{unit}, got {shown(number)}", reason="target")
    return float(number)


def check_count(number: Any, what: str) -> int:
    """Give a whole number.

    Args:
        number: The number.
        what: How the error calls it.

    Raises:
        MotionError: When it is not a whole number, or below 0.
    """
    whole = isinstance(number, int | np.integer) and not isinstance(number, bool)
    if not whole or number < 0:
        raise MotionError(
            f"{what} is a whole number, 0 or above, got {shown(number)}", reason="target"
        )
    return int(number)


def check_number(number: Any, what: str, unit: str) -> float:
    """Give a finite number.

    Args:
        number: Of either sign.
        what: How the error calls it.
        unit: Its unit.

    Raises:
        MotionError: When it is none.
    """
    array = as_numbers(number)
    if array.shape != () or not np.isfinite(array):
        raise MotionError(
            f"{what} is a finite number [{unit}], got {shown(number)}", reason="target"
        )
    return float(array)


def check_vector(vector: Any, what: str) -> np.ndarray:
    """Give a place or a direction as a new array.

    Args:
        vector: Three numbers.
        what: How the error calls it.

    Raises:
        MotionError: When it has another shape than (3,), or is not finite.
    """
    array = as_numbers(vector)
    if array.shape != (3,) or not isfinite(sum(array.tolist())):
        raise MotionError(f"{what} is three finite numbers, got {shown(vector)}", reason="target")
    return array


def check_matrix(matrix: Any, what: str) -> np.ndarray:
    """Give a matrix as a new array.

    Args:
        matrix: Rows of numbers.
        what: How the error calls it.

    Raises:
        MotionError: When it has another shape than (m, n), or is empty or not finite.
    """
    array = as_numbers(matrix)
    if array.ndim != 2 or not array.size or not np.isfinite(array).all():
        raise MotionError(
            f"{what} is a matrix of finite numbers, got {shown(matrix)}", reason="target"
        )
    return array


def check_generator(rng: Any) -> np.random.Generator:
    """Give a source of chance back.

    Raises:
        MotionError: When it is no `numpy.random.Generator`.
    """
    if not isinstance(rng, np.random.Generator):
        raise MotionError(
            f"chance comes from a numpy.random.Generator, got {shown(rng)}", reason="target"
        )
    return rng


def as_numbers(value: Any) -> np.ndarray:
    """Copy what is a regular array of numbers; all else, text too, becomes NaN."""
    if type(value) is np.ndarray and value.dtype is _FLOAT:
        return value.copy()
    try:
        array = np.array(value)
        if array.dtype is _FLOAT:
            return array
        if array.dtype.kind in "biufO":
            return array.astype(float)
    except (TypeError, ValueError, OverflowError):
        pass
    return np.array(np.nan)


def shown(value: Any) -> str:
    """Write what was found as errors show it: in one line, and not a long one."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
