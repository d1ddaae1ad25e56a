"""Check the arguments of motion requests.

All checks raise `MotionError` with the reason ``"target"``: its message names the argument, says
what would be right and shows what was given. Numbers written as text and booleans are no numbers.
"""

from math import inf, isfinite
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError, shown
from bt_manip.spatial import as_numbers

ROTATION_TOLERANCE = 1e-6  # of the lengths and angles of a rotation matrix's axes
POSITION_ROUNDING = 1e-6  # [rad] beyond a position limit that counts as at the limit


def invalid(message: str) -> MotionError:
    """Make the error for an invalid argument."""
    return MotionError(message, reason="target")


def check_number(
    value: Any,
    name: str,
    unit: str = "",
    *,
    above: float = -inf,
    at_least: float = -inf,
    at_most: float = inf,
) -> float:
    """Return a finite number within bounds as a float."""
    if isinstance(value, float):
        number = float(value)
    else:
        array = as_numbers(value)
        number = float(array) if array.shape == () else np.nan
    if above < number < inf and at_least <= number <= at_most:
        return number
    lower = f"above {above:g}" if above > -inf else f"at least {at_least:g}"
    bounds = [lower] * (max(above, at_least) > -inf) + [f"at most {at_most:g}"] * (at_most < inf)
    required = " and ".join(bounds) or "a finite number"
    raise invalid(f"{name} must be {required}{unit and f' [{unit}]'}, got {shown(value)}")


def check_positive(value: Any, name: str, unit: str = "") -> float:
    """Return a number above 0 as a float."""
    return check_number(value, name, unit, above=0.0)


def check_non_negative(value: Any, name: str, unit: str = "") -> float:
    """Return a number of at least 0 as a float."""
    return check_number(value, name, unit, at_least=0.0)


def check_speed(value: Any) -> float:
    """Return a speed, a fraction of the limits above 0 and at most 1."""
    return check_number(value, "speed", above=0.0, at_most=1.0)


def check_count(value: Any, name: str) -> int:
    """Return an integer of at least 0 as an int."""
    if not isinstance(value, int | np.integer) or isinstance(value, bool) or value < 0:
        raise invalid(f"{name} must be an integer of at least 0, got {shown(value)}")
    return int(value)


def check_vector(value: Any, name: str, unit: str = "", *, size: int = 3) -> np.ndarray:
    """Return a vector of finite numbers as a new array."""  # (size,)
    array = as_numbers(value)
    if array.shape != (size,) or not isfinite(sum(array.tolist())):
        required = f"{size} finite numbers{unit and f' [{unit}]'}"
        raise invalid(f"{name} must be {required}, got {shown(value)}")
    return array


def check_configuration(q: Any, n: int) -> np.ndarray:
    """Return a configuration as a new array."""  # (n,)
    return check_vector(q, "configuration", "rad", size=n)


def check_pose(T: Any, name: str = "pose") -> pin.SE3:
    """Return a finite pose with a valid rotation."""
    if not isinstance(T, pin.SE3):
        raise invalid(f"{name} must be a pin.SE3, got {type(T).__name__}")
    first, second, third, _ = T.homogeneous.tolist()
    if not _are_axes(first, second, third):
        raise _invalid_rotation(T.rotation, f"rotation of the {name}")
    if not isfinite(first[3] + second[3] + third[3]):
        raise invalid(f"position of the {name} must be finite, got {shown(T.translation)}")
    return T


def check_rotation(rotation: Any, name: str = "rotation") -> np.ndarray:
    """Return a rotation matrix as a new array."""  # (3, 3)
    R = as_numbers(rotation)
    if R.shape != (3, 3) or not _are_axes(*R.tolist()):
        raise _invalid_rotation(rotation, name)
    return R


def check_generator(rng: Any) -> np.random.Generator:
    """Return a random generator."""
    if not isinstance(rng, np.random.Generator):
        raise invalid(f"rng must be a numpy.random.Generator, got {shown(rng)}")
    return rng


def _invalid_rotation(rotation: Any, name: str) -> MotionError:
    return invalid(
        f"{name} must be a 3 by 3 matrix of right-handed unit axes, got {shown(rotation)}"
    )


def _are_axes(first: list[float], second: list[float], third: list[float]) -> bool:
    """Tell whether rows of at least three numbers begin with a rotation matrix."""
    # Plain floats are faster here than arrays: two orthogonal unit rows, and the third their
    # cross product. Comparisons with NaN and infinity fail.
    a, b, c, d, e, f, g, h, i = *first[:3], *second[:3], *third[:3]
    return (
        abs(a * a + b * b + c * c - 1.0) <= ROTATION_TOLERANCE
        and abs(d * d + e * e + f * f - 1.0) <= ROTATION_TOLERANCE
        and abs(a * d + b * e + c * f) <= ROTATION_TOLERANCE
        and abs(b * f - c * e - g) <= ROTATION_TOLERANCE
        and abs(c * d - a * f - h) <= ROTATION_TOLERANCE
        and abs(a * e - b * d - i) <= ROTATION_TOLERANCE
    )
