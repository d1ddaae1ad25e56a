"""Checks of user-given gains."""

from collections.abc import Sequence

import numpy as np

from .exceptions import ControlError


def per_joint(name: str, gain: float | Sequence[float] | np.ndarray, n: int) -> np.ndarray:
    """Return one gain per joint.

    Args:
        name: Name of the gain, for the message.
        gain: One number for all joints, or one per joint.
        n: Number of joints.

    Raises:
        ControlError: If a gain is negative or not finite, or their number is wrong.
    """  # (n,)
    gains = np.array(gain, dtype=float)
    if gains.shape not in ((), (n,)):
        raise ControlError(f"{name} is one number, or one for each of {n} joints, got {gain!r}")
    if not np.isfinite(gains).all() or (gains < 0).any():
        raise ControlError(f"{name} must be finite and not negative, got {gain!r}")
    return np.full(n, gains)
