"""References of arm controllers."""

from typing import Protocol, runtime_checkable

import numpy as np

from bt_manip.robots import Payload


@runtime_checkable
class Reference(Protocol):
    """A joint-space motion, evaluated at the present time; a base class with defaults.

    The controller reads ``q``, ``v`` and ``a`` before each step, and calls ``advance`` after it, so
    that between steps the reference and the measured state are of the same time.
    """

    q: np.ndarray  # (nq,) [rad]
    v: np.ndarray  # (nq,) [rad/s]
    a: np.ndarray  # (nq,) [rad/s2]
    payload: Payload | None = None
    """Payload of the arm; a change updates the controller's model."""
    compliant: bool = False
    """Whether the controller yields to contact: soft and without integral action."""

    def advance(self, dt: float) -> None:
        """Advance by one control step [s]."""

    def hold_at(self, q: np.ndarray) -> None:
        """Continue from a measured configuration if at rest [rad]; default: do nothing.

        Called when another controller takes over; moving references ignore it.
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
