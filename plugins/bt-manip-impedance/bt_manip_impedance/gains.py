"""Checks of stiffness and damping arguments."""

from collections.abc import Sequence

import numpy as np

from bt_manip.control import ControlError


def stiffnesses(name: str, given: float | Sequence[float] | np.ndarray, n: int) -> np.ndarray:
    """Return n stiffnesses from one number, or from n.

    Raises:
        ControlError: If a number is negative or not finite, or their count is wrong.
    """
    values = np.asarray(given, dtype=float)
    if values.shape not in ((), (n,)):
        raise ControlError(f"{name} is one number, or one for each of {n}, got {given!r}")
    if not np.isfinite(values).all() or (values < 0.0).any():
        raise ControlError(f"{name} must be finite and not negative, got {given!r}")
    return np.broadcast_to(values, (n,)).copy()


def ratio(name: str, given: float) -> float:
    """Return a damping ratio.

    Raises:
        ControlError: If it is negative or not finite.
    """
    if not 0.0 <= given < np.inf:
        raise ControlError(f"{name} must be finite and not negative, got {given!r}")
    return float(given)
