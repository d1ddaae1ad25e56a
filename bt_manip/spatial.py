"""Poses as ``pin.SE3``, and their conversion to and from MuJoCo's arrays.

``T_wb`` is the pose of frame b in frame w. Names of quaternions state the order of the elements:
``quat_wxyz`` in MuJoCo, ``quat_xyzw`` in Pinocchio.
"""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

_FLOAT = np.dtype(float)


def pose(
    position: Sequence[float] | np.ndarray,
    quat_wxyz: Sequence[float] | np.ndarray = (1.0, 0.0, 0.0, 0.0),
) -> pin.SE3:
    """Return the pose with a position and an orientation.

    Args:
        position: Origin of the frame [m].  # (3,)
        quat_wxyz: Orientation; normalized here.  # (4,)

    Raises:
        ValueError: If a number is not finite or the quaternion is zero.
    """
    p = np.asarray(position, dtype=float)
    w, x, y, z = quat_wxyz.tolist() if isinstance(quat_wxyz, np.ndarray) else map(float, quat_wxyz)
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    numbers = p.tolist()
    if p.shape != (3,) or not all(map(math.isfinite, numbers)):
        raise ValueError(f"a position is three finite numbers [m], got {position!r}")
    if not math.isfinite(norm) or norm < 1e-9:
        raise ValueError(f"a quaternion is four finite numbers, not all zero, got {quat_wxyz!r}")
    numbers += (x / norm, y / norm, z / norm, w / norm)
    return pin.XYZQUATToSE3(np.array(numbers))


def quat_wxyz(T: pin.SE3) -> np.ndarray:
    """Return the orientation of a pose as a unit quaternion in MuJoCo's order."""  # (4,)
    x, y, z, w = pin.Quaternion(T.rotation).coeffs()
    return np.array([w, x, y, z])


def pointing_down(position: Sequence[float] | np.ndarray, yaw: float = 0.0) -> pin.SE3:
    """Return a tool pose whose z axis points straight down.

    Args:
        position: Origin of the tool [m].  # (3,)
        yaw: Angle of the tool's x axis about the world's vertical [rad].
    """
    c, s = np.cos(yaw), np.sin(yaw)
    rotation = np.array([[c, s, 0.0], [s, -c, 0.0], [0.0, 0.0, -1.0]])
    return pin.SE3(rotation, np.asarray(position, dtype=float))


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the cross product of two vectors, ten times as fast as NumPy's and with its bits."""
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])  # (3,)


def as_numbers(value: Any) -> np.ndarray:
    """Return a regular array of numbers as a new array of floats; NaN for everything else."""
    if type(value) is np.ndarray and value.dtype is _FLOAT:
        return value.copy()
    try:
        array = np.array(value)
    except (TypeError, ValueError, OverflowError):
        return np.array(np.nan)
    return array.astype(float, copy=False) if array.dtype.kind in "iuf" else np.array(np.nan)
