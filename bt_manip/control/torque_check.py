"""Check the torques of a controller before the motors get them."""

from collections.abc import Sequence

import numpy as np


def torque_problem(
    tau: np.ndarray, limit: np.ndarray, names: Sequence[str], *, saturates: bool
) -> str:
    """Describe why torques must not be commanded; empty if they can be clipped to the limits.

    Args:
        tau: Joint torques, at least one of them not within its limit [N m].  # (nv,)
        limit: Effort limits [N m].  # (nv,)
        names: Names of the joints.
        saturates: Whether torques beyond the limits are clipped instead.
    """
    finite = np.isfinite(tau)
    if not finite.all():
        joint = int(np.flatnonzero(~finite)[0])
        return f"returned {tau[joint]} for the torque of joint '{names[joint]}'"
    if saturates:
        return ""
    joint = int(np.argmax(np.abs(tau) / limit))
    return (
        f"returned {tau[joint]:.4g} N m for joint '{names[joint]}', whose limit is "
        f"{limit[joint]:g} N m (set saturates = True in a controller whose torques are to be "
        "clipped)"
    )
