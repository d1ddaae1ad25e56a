"""References of arm controllers."""

from typing import Protocol, runtime_checkable

import numpy as np

from bt_manip.robots import Payload


@runtime_checkable
class Reference(Protocol):
    """A joint-space motion, evaluated at the present time; derive from it for the defaults.

    The controller reads ``q``, ``v`` and ``a`` for the step that begins, and calls ``advance``
    after it: the reference and the measured state belong to the same time between steps.
    """

    q: np.ndarray  # (nq,) [rad]
    v: np.ndarray  # (nq,) [rad/s]
    a: np.ndarray  # (nq,) [rad/s2]
    payload: Payload | None = None
    """Payload of the arm; the controller's model includes it from when it changes."""
    compliant: bool = False
    """Whether the controller yields to contact: soft and without integral action."""

    def advance(self, dt: float) -> None:
        """Advance by one control step [s]."""

    def hold_at(self, q: np.ndarray) -> None:
        """Continue from a measured configuration where at rest [rad]; default: do nothing.

        Called when another controller takes over; a moving reference ignores it.
        """


class Hold(Reference):
    """A constant configuration."""

    def __init__(self, q: np.ndarray):
        self.q = np.array(q, dtype=float)
        self.v = np.zeros_like(self.q)
        self.a = np.zeros_like(self.q)

    def advance(self, dt: float) -> None:
        """Do nothing."""

    def hold_at(self, q: np.ndarray) -> None:
        """Hold another configuration [rad]."""  # (nq,)
        self.q[:] = q
