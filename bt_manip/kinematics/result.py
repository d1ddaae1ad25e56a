"""What an inverse kinematics request ends with."""

from typing import NamedTuple

import numpy as np


class Residual(NamedTuple):
    """How far a frame is from its target.

    Attributes:
        frame: The frame's name.
        position: Its distance [m], 0 for a rotation.
        rotation: Its angle [rad], 0 for a position.
        met: Whether it is within the tolerances; a cost always is.
    """

    frame: str
    position: float
    rotation: float
    met: bool


class IKResult(NamedTuple):
    """A configuration for a request, or the nearest that was found.

    Attributes:
        q: The configuration, inside the limits.  # (nq,)
        solved: Whether all constraints are met.
        residuals: One for each target, in the order of the request.
        iterations: Steps taken, over all restarts.
        restarts: How many starts after the first.
        reason: Why it is not solved; empty when it is.
        target: Which of several alternative poses this is for.
        cost: What costs and preferences of the problem sum up to; 0 where it has none.
    """

    q: np.ndarray
    solved: bool
    residuals: tuple[Residual, ...]
    iterations: int
    restarts: int = 0
    reason: str = ""
    target: int = 0
    cost: float = 0.0

    @property
    def position_error(self) -> float:
        """Largest distance of a frame from its target [m]."""
        return max(residual.position for residual in self.residuals)

    @property
    def rotation_error(self) -> float:
        """Largest angle between a frame and its target [rad]."""
        return max(residual.rotation for residual in self.residuals)
