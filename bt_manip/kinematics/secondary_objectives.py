"""Secondary objectives: the cost of a configuration subject to constraints."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel

from .manipulability import log_manipulability
from .residuals import FrameResidual, StackedResidual


class QuadraticModel(NamedTuple):
    """A cost near a configuration: value, gradient and positive semidefinite Hessian."""

    value: float
    gradient: np.ndarray  # (nv,)
    hessian: np.ndarray  # (nv, nv)


class SecondaryObjectives:
    """Sum of weighted residuals, a distance from a posture, and the tool's manipulability.

    Args:
        inverse_speed: Inverse of the maximum joint velocities [s/rad].  # (nq,)
        residuals: Residuals of targets, scaled by the square roots of their weights.
        posture: A configuration [rad], and the weight of half the squared distance [1/s2].
        manipulability: The arm, a mask of its moving joints, and the weight of the logarithm.
    """

    def __init__(
        self,
        inverse_speed: np.ndarray,
        *,
        residuals: Sequence[FrameResidual] = (),
        posture: tuple[np.ndarray, float] | None = None,
        manipulability: tuple[RobotModel, np.ndarray | None, float] | None = None,
    ) -> None:
        self._residuals, self._posture = tuple(residuals), posture
        self._manipulability = manipulability
        self._metric = inverse_speed**2 / len(inverse_speed)

    def expand(self, constraints: StackedResidual) -> QuadraticModel:
        """Return the cost with its gradient and its Gauss-Newton Hessian.

        Args:
            constraints: Constraints, last evaluated at the configuration.
        """
        q = constraints.q
        assert q is not None
        n = len(q)
        value, gradient, hessian = 0.0, np.zeros(n), np.zeros((n, n))
        for residual in self._residuals:
            error, jacobian = residual.evaluate(), residual.jacobian()
            value += 0.5 * float(error.dot(error))
            gradient += jacobian.T @ error
            hessian += jacobian.T @ jacobian
        if self._posture is not None:
            posture, weight = self._posture
            offset, weights = q - posture, weight * self._metric
            value += 0.5 * float(offset.dot(weights * offset))
            gradient += weights * offset
            hessian.ravel()[:: n + 1] += weights
        if self._manipulability is not None:
            arm, moving, weight = self._manipulability
            logarithm, slope = log_manipulability(arm, moving)
            value -= weight * logarithm
            gradient -= weight * slope
            # Approximates the Hessian of the logarithm, which changes by about 1 over a radian.
            hessian.ravel()[:: n + 1] += weight
        return QuadraticModel(value, gradient, hessian)
