"""Look at what a controller gives before an arm gets it."""

from collections.abc import Sequence

import numpy as np


def problem_with(tau: np.ndarray, limit: np.ndarray, names: Sequence[str], *, cuts: bool) -> str:
    """Say what is wrong with efforts that are not all inside the limits; nothing if they will do.

    Args:
        tau: What the controller gave [N m].  # (nv,)
        limit: Effort limits [N m].  # (nv,)
        names: Names of the joints.
        cuts: Whether efforts beyond the limits are cut instead.
    """
    finite = np.isfinite(tau)
    if not finite.all():
        joint = int(np.flatnonzero(~finite)[0])
        return f"gave {tau[joint]} for the effort of joint '{names[joint]}'"
    if cuts:
        return ""
    joint = int(np.argmax(np.abs(tau) / limit))
    return (
        f"gave {tau[joint]:.4g} N m for joint '{names[joint]}', whose limit is {limit[joint]:g} "
        "N m (a controller that leaves the cutting to others says so: cuts_to_limits = True)"
    )
