"""What a controller follows."""

from typing import Protocol

import numpy as np


class Reference(Protocol):
    """A motion in joint space, known at the present time.

    ``q``, ``v`` and ``a`` are those of the cell's time. The controller reads them for the step
    that begins now and calls ``advance`` when the step has been made, so that whoever compares
    afterwards finds the reference and the robot at the same time.
    """

    q: np.ndarray  # (nq,) [rad]
    v: np.ndarray  # (nq,) [rad/s]
    a: np.ndarray  # (nq,) [rad/s2]

    def advance(self, dt: float) -> None:
        """Go on by a control step [s]."""


class Hold:
    """Stay at a configuration."""

    def __init__(self, q: np.ndarray):
        """Stay at ``q`` [rad]."""  # (nq,)
        self.q = np.array(q, dtype=float)
        self.v = np.zeros_like(self.q)
        self.a = np.zeros_like(self.q)

    def advance(self, dt: float) -> None:
        """Stay."""
