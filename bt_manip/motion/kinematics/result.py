"""What an inverse kinematics request ends with."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class IKResult:
    """A configuration for a pose, or the nearest that was found.

    Attributes:
        q: The configuration, inside the limits.  # (nq,)
        solved: Whether both errors are within their tolerances.
        position_error: Distance of the tool from the target [m].
        rotation_error: Angle between tool and target [rad].
        iterations: Steps taken, over all restarts.
        restarts: How many starts after the first.
        reason: Why it is not solved; empty when it is.
        target: Which of several alternative poses this is for.
    """

    q: np.ndarray
    solved: bool
    position_error: float
    rotation_error: float
    iterations: int
    restarts: int = 0
    reason: str = ""
    target: int = 0
