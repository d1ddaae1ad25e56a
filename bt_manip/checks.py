"""Refuse what is not a pose, a configuration or a speed, before anything is planned with it."""

from math import isfinite
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError
from bt_manip.number_checks import as_numbers, shown

_RIGHT = 1e-6  # that a rotation matrix may be off


def check_pose(T_wt: Any) -> pin.SE3:
    """Give a pose back.

    Raises:
        MotionError: When it is no `pin.SE3`, not finite, or its rotation is none.
    """
    if not isinstance(T_wt, pin.SE3):
        raise MotionError(f"a pose is a pin.SE3, got {type(T_wt).__name__}", reason="target")
    first, second, third, _ = T_wt.homogeneous.tolist()
    if _are_axes(first, second, third) and isfinite(first[3] + second[3] + third[3]):
        return T_wt
    if not isfinite(sum(first) + sum(second) + sum(third)):
        raise MotionError(
            f"the pose is not finite: its position is {_row(T_wt.translation)} [m], its rotation "
            f"{_matrix(T_wt.rotation)}",
            reason="target",
        )
    raise MotionError(
        "the pose's rotation is none: a rotation is a 3 by 3 matrix of right-handed unit axes, "
        f"got {_matrix(T_wt.rotation)}",
        reason="target",
    )


def check_rotation(rotation: Any) -> np.ndarray:
    """Give a rotation matrix as a new array.

    Raises:
        MotionError: When it is none.
    """
    R = as_numbers(rotation)
    if R.shape != (3, 3) or not _are_axes(*R.tolist()):
        found = _matrix(R) if R.shape == (3, 3) else shown(rotation)
        raise MotionError(
            f"a rotation is a 3 by 3 matrix of right-handed unit axes, got {found}",
            reason="target",
        )
    return R


def _are_axes(first: list[float], second: list[float], third: list[float]) -> bool:
    """Tell whether rows of three numbers, or of more, begin with a rotation."""
    # Plain numbers are faster here than arrays: two unit rows at right angles, and the third
    # their product. A comparison with what is not finite fails.
    a, b, c, d, e, f, g, h, i = *first[:3], *second[:3], *third[:3]
    return (
        abs(a * a + b * b + c * c - 1.0) <= _RIGHT
        and abs(d * d + e * e + f * f - 1.0) <= _RIGHT
        and abs(a * d + b * e + c * f) <= _RIGHT
        and abs(b * f - c * e - g) <= _RIGHT
        and abs(c * d - a * f - h) <= _RIGHT
        and abs(a * e - b * d - i) <= _RIGHT
    )


def check_poses(targets: Any) -> list[pin.SE3]:
    """Give one pose or several equivalent ones as a list.

    Raises:
        MotionError: When there is none, or one is no pose.
    """
    poses = [targets] if isinstance(targets, pin.SE3) or not _is_many(targets) else list(targets)
    if not poses:
        raise MotionError("no target pose was given", reason="target")
    return [check_pose(pose) for pose in poses]


def check_configuration(q: Any, n: int) -> np.ndarray:
    """Give a configuration as a new array.

    Raises:
        MotionError: When it has another shape than (n,), or is not finite.
    """
    array = as_numbers(q)
    if array.shape != (n,) or not isfinite(sum(array.tolist())):
        raise MotionError(
            f"a configuration is {n} finite numbers [rad], got {shown(q)}", reason="target"
        )
    return array


def check_inside(q: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> None:
    """Refuse a configuration outside the position limits.

    Raises:
        MotionError: Naming the first such joint.
    """
    outside = (q < lower) | (q > upper)
    if outside.any():
        i = int(np.flatnonzero(outside)[0])
        raise MotionError(
            f"joint {i + 1} cannot go to {q[i]:.4f} rad: its limits are "
            f"{lower[i]:.4f} to {upper[i]:.4f} rad",
            reason="target",
        )


def check_speed(speed: Any) -> float:
    """Give a speed as a number.

    Raises:
        MotionError: When it is not above 0 and at most 1.
    """
    try:
        number = float(speed)
    except (TypeError, ValueError):
        number = 0.0
    if not 0.0 < number <= 1.0:
        raise MotionError(f"a speed is above 0 and at most 1, got {shown(speed)}", reason="target")
    return number


def check_speed_scale(pace: Any) -> float:
    """Give a pace as a number.

    Raises:
        MotionError: When it is not from 0 to 1.
    """
    try:
        number = float(pace)
    except (TypeError, ValueError):
        number = -1.0
    if not 0.0 <= number <= 1.0:
        raise MotionError(f"a pace is from 0 to 1, got {shown(pace)}", reason="target")
    return number


def _row(numbers: np.ndarray) -> str:
    return f"({', '.join(f'{x:.4g}' for x in numbers.tolist())})"


def _matrix(rows: np.ndarray) -> str:
    return f"({', '.join(map(_row, rows))})"


def _is_many(targets: Any) -> bool:
    return isinstance(targets, list | tuple)
