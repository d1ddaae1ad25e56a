"""What a solution should be like, beside what it must be."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .manipulability import ToolManipulability
from .rows import Rows
from .system import System


class Expansion(NamedTuple):
    """A cost near a configuration: its value, gradient and (positive) curvature."""

    value: float
    gradient: np.ndarray  # (nv,)
    curvature: np.ndarray  # (nv, nv)


class Posture(NamedTuple):
    """A posture to be near to.

    Attributes:
        q: The posture [rad].  # (nq,)
        weight: Of half the squared distance [1/s2].
    """

    q: np.ndarray
    weight: float


class SecondaryObjectives:
    """The cost of a configuration: of targets, of a distance from a posture, of manipulability."""

    def __init__(
        self,
        inverse_speed: np.ndarray,
        *,
        rows: Sequence[Rows] = (),
        posture: Posture | None = None,
        manipulability: tuple[ToolManipulability, float] | None = None,
    ) -> None:
        """Sum up costs.

        Args:
            inverse_speed: What a joint's way counts in the distance from a posture [s/rad].
            rows: Errors of targets, scaled by the roots of their weights.
            posture: A posture to be near to.
            manipulability: Makes the tool able to move, with a weight.
        """
        self.rows, self._posture, self._manipulability = tuple(rows), posture, manipulability
        self._metric = inverse_speed**2 / len(inverse_speed)

    def measure(self, system: System) -> float:
        """Give the cost at the configuration that a system last looked at."""
        return self._sum(system, slope=False).value

    def expand(self, system: System) -> Expansion:
        """Give the cost with its slope and the curvature that Gauss and Newton would take."""
        return self._sum(system, slope=True)

    def _sum(self, system: System, slope: bool) -> Expansion:
        q = system.q
        assert q is not None
        n = len(q)
        value, gradient, curvature = 0.0, np.zeros(n), np.zeros((n, n))
        for row in self.rows:
            error = row.measure()
            value += 0.5 * float(error.dot(error))
            if slope:
                jacobian = row.jacobian()
                gradient += jacobian.T @ error
                curvature += jacobian.T @ jacobian
        if self._posture is not None:
            away = q - self._posture.q
            pull = self._posture.weight * self._metric
            value += 0.5 * float(away.dot(pull * away))
            gradient += pull * away
            curvature.ravel()[:: n + 1] += pull
        if self._manipulability is not None:
            tool, weight = self._manipulability
            logarithm, rise = tool.measure()
            value -= weight * logarithm
            gradient -= weight * rise
            # The logarithm bends by about 1 over a radian.
            curvature.ravel()[:: n + 1] += weight
        return Expansion(value, gradient, curvature)
