"""Results of inverse kinematics."""

from typing import NamedTuple

import numpy as np


class Residual(NamedTuple):
    """Error of a frame from its target.

    Attributes:
        frame: Name of the frame.
        position: Distance [m], 0 for a rotation.
        rotation: Angle [rad], 0 for a position.
        met: Whether both are within the tolerances; always true for a cost.
    """

    frame: str
    position: float
    rotation: float
    met: bool


class IKResult(NamedTuple):
    """A solution, or the configuration of the smallest residual.

    Attributes:
        q: The configuration, inside the limits.  # (nq,)
        solved: Whether all constraints are met.
        residuals: One for each target, in the order of the request.
        iterations: Iterations over all initial guesses.
        restarts: Number of initial guesses after the first.
        reason: Why it is not solved; empty when it is.
        target: Index of the pose that it is for, of several alternative ones.
        cost: Sum of the problem's costs; 0 where it has none.
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
