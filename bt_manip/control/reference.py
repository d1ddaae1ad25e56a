"""References of arm controllers."""

from typing import Protocol

import numpy as np


class Reference(Protocol):
    """A joint-space motion, evaluated at the present time.

    The controller reads ``q``, ``v`` and ``a`` for the step that begins, and calls ``advance``
    after it: the reference and the measured state belong to the same time between steps.

    A reference may also have

    - ``payload``, the `Payload` of the arm, which the controller's model then includes;
    - ``compliant``, whether the controller yields to contact: soft and without integral action;
    - ``hold_at(q)``, called when another controller takes over: a reference at rest continues from
      the measured configuration ``q``, a moving one ignores it.
    """

    q: np.ndarray  # (nq,) [rad]
    v: np.ndarray  # (nq,) [rad/s]
    a: np.ndarray  # (nq,) [rad/s2]

    def advance(self, dt: float) -> None:
        """Advance by one control step [s]."""


class Hold:
    """A constant configuration."""

    def __init__(self, q: np.ndarray):
        """Hold ``q`` [rad]."""  # (nq,)
        self.q = np.array(q, dtype=float)
        self.v = np.zeros_like(self.q)
        self.a = np.zeros_like(self.q)

    def advance(self, dt: float) -> None:
        """Do nothing."""

    def hold_at(self, q: np.ndarray) -> None:
        """Hold another configuration [rad]."""  # (nq,)
        self.q[:] = q
