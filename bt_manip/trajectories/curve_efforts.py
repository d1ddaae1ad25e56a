"""What the efforts of an arm that goes along a curve are made of."""

from typing import NamedTuple

import numpy as np

from bt_manip.robots import RobotModel


class CurveEfforts(NamedTuple):
    """Efforts at some places of a curve: ``rates u + squares p^2 + linear p + gravity + friction``.

    There ``p`` is the rate at which the place goes on, and ``u`` the change of that.

    Attributes:
        rates: What multiplies u.  # (n, nq)
        squares: What multiplies p^2.  # (n, nq)
        linear: What multiplies p: damping.  # (n, nq)
        gravity: What it takes to stand there [N m].  # (n, nq)
        friction: What dry friction takes beside that, going on [N m].  # (n, nq)
    """

    rates: np.ndarray
    squares: np.ndarray
    linear: np.ndarray
    gravity: np.ndarray
    friction: np.ndarray

    @property
    def by_power(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """What multiplies u, p^2, p and 1."""  # (n, nq) each
        return self.rates, self.squares, self.linear, self.gravity + self.friction

    @classmethod
    def along(
        cls, model: RobotModel, x: np.ndarray, d1: np.ndarray, d2: np.ndarray
    ) -> "CurveEfforts":
        """Look at a curve at some places.

        Args:
            model: The arm with its payload.
            x: Coordinates there, the joints before all others.  # (n, m)
            d1: Their first derivatives.  # (n, m)
            d2: Their second derivatives.  # (n, m)
        """
        q, v, a = (rows[:, : model.nq] for rows in (x, d1, d2))
        still = np.zeros(model.nq)
        gravity = np.array([model.rnea(row, still, still) for row in q])
        inertia = np.array([model.rnea(row, still, rate) for row, rate in zip(q, v, strict=True)])
        motion = np.array([model.rnea(*row) for row in zip(q, v, a, strict=True)])
        friction = model.friction * np.sign(v)
        return cls(inertia - gravity, motion - gravity, model.damping * v, gravity, friction)
