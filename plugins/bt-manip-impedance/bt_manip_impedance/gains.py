"""Check what users ask of springs and dampers."""

from collections.abc import Sequence

import numpy as np

from bt_manip.control import ControlError


def stiffnesses(name: str, given: float | Sequence[float] | np.ndarray, n: int) -> np.ndarray:
    """Give n stiffnesses from one for all, or one for each.

    Raises:
        ControlError: When a number is negative or not finite, or there are too many or few.
    """
    values = np.asarray(given, dtype=float)
    if values.shape not in ((), (n,)):
        raise ControlError(f"{name} is one number, or one for each of {n}, got {given!r}")
    if not np.isfinite(values).all() or (values < 0.0).any():
        raise ControlError(f"{name} must be finite and not negative, got {given!r}")
    return np.broadcast_to(values, (n,)).copy()


def ratio(name: str, given: float) -> float:
    """Give a damping ratio.

    Raises:
        ControlError: When it is negative or not finite.
    """
    if not 0.0 <= given < np.inf:
        raise ControlError(f"{name} must be finite and not negative, got {given!r}")
    return float(given)
