"""Dynamics and limits of an arm along a path.

With the path velocity s_dot and the path acceleration s_ddot, joint accelerations and efforts are
linear in ``x = s_dot^2`` and ``u = s_ddot`` (K. M. Lynch and F. C. Park, Modern Robotics, 2017,
section 9.4), except for damping, which is linear in s_dot.
"""

from typing import NamedTuple

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel

from .limit_check import EFFORT_FRACTION
from .path_limits import TINY, PathLimits
from .paths import Path

MAX_DAMPING = 0.9  # of the effort left for moving, at most, taken by damping
NEGLIGIBLE_DAMPING = 0.05  # of an effort limit: whether damping is known exactly does not matter


class PathDynamics(NamedTuple):
    """Motor efforts ``m u + c x + d s_dot + g + f`` at n points of a path, moving forward.

    Attributes:
        mass: m, multiplies the path acceleration.  # (n, nq)
        coriolis: c, multiplies the squared path velocity.  # (n, nq)
        damping: d, multiplies the path velocity.  # (n, nq)
        gravity: g [N m].  # (n, nq)
        friction: f, dry friction [N m].  # (n, nq)
    """

    mass: np.ndarray
    coriolis: np.ndarray
    damping: np.ndarray
    gravity: np.ndarray
    friction: np.ndarray

    @classmethod
    def along(
        cls, model: RobotModel, x: np.ndarray, d1: np.ndarray, d2: np.ndarray
    ) -> "PathDynamics":
        """Evaluate the dynamics at points of a path.

        Args:
            model: The arm with its payload.
            x: Coordinates, the joints first.  # (n, m)
            d1: Their first derivatives by s.  # (n, m)
            d2: Their second derivatives by s.  # (n, m)
        """
        q, v, a = (rows[:, : model.nq] for rows in (x, d1, d2))
        zero = np.zeros(model.nq)
        gravity = np.array([model.rnea(row, zero, zero) for row in q])
        mass = np.array([model.rnea(row, zero, slope) for row, slope in zip(q, v, strict=True)])
        coriolis = np.array([model.rnea(*row) for row in zip(q, v, a, strict=True)])
        friction = model.friction * np.sign(v)
        return cls(mass - gravity, coriolis - gravity, model.damping * v, gravity, friction)


class PathConstraints:
    """Constraints ``-below <= a u + b x <= above`` at points of a path.

    Args:
        path: The path.
        s: Path parameters of the points.  # (n,)
        limits: Limits of its coordinates.
        model: The arm with its payload; None ignores efforts.

    Attributes:
        a: Multiplies the path acceleration u.  # (n, k)
        b: Multiplies the squared path velocity x.  # (n, k)
        max_s_dot: Greatest path velocity that velocity limits and damping allow.  # (n,)
        damped: Whether damping is more than negligible.

    Raises:
        MotionError: When the arm cannot even hold itself on the path.
    """

    def __init__(
        self,
        path: Path,
        s: np.ndarray,
        limits: PathLimits,
        model: RobotModel | None,
    ) -> None:
        x, d1, d2 = path.evaluate(s)
        bounded = [(limit, slopes) for _, slopes, limit in limits.speeds(x, d1)]
        self.a, self.b, self.damped = d1, d2, False
        self._acceleration = np.broadcast_to(limits.acceleration, d1.shape)
        self._dynamics: PathDynamics | None = None
        if model is not None:
            dynamics = self._dynamics = PathDynamics.along(model, x, d1, d2)
            self._effort = effort = EFFORT_FRACTION * model.limits.effort
            _check_holding(dynamics.gravity, dynamics.friction, effort)
            # The damping of some models takes all effort that gravity leaves (or adds) before the
            # joint is at its velocity limit.
            left = effort - model.friction - np.sign(d1[:, : model.nq]) * dynamics.gravity
            damping_limited = MAX_DAMPING * left / (model.damping + TINY)
            bounded.append((damping_limited, d1[:, : model.nq]))
            full_damping = model.damping * model.limits.velocity
            self.damped = bool((full_damping > NEGLIGIBLE_DAMPING * effort).any())
            self.a = np.hstack([self.a, dynamics.mass])
            self.b = np.hstack([self.b, dynamics.coriolis])
        s_dots = [(limit / (np.abs(slopes) + TINY)).min(axis=1) for limit, slopes in bounded]
        self.max_s_dot = np.min(s_dots, axis=0)

    def bounds(self, s_dot: np.ndarray) -> np.ndarray:
        """Return above and below, with the damping of given path velocities."""  # (2, n, k)
        sides = self._acceleration[np.newaxis].repeat(2, axis=0)
        if self._dynamics is None:
            return sides
        _, _, damping, gravity, friction = self._dynamics
        lost = gravity + friction + damping * s_dot[:, np.newaxis]
        return np.concatenate([sides, [self._effort - lost, self._effort + lost]], axis=-1)


def _check_holding(gravity: np.ndarray, friction: np.ndarray, effort: np.ndarray) -> None:
    """Check that efforts suffice to move as slowly as needed through each point."""
    needed = np.abs(gravity + friction)
    use = needed / effort
    if use.max(initial=0.0) >= 1.0:
        i, joint = np.unravel_index(use.argmax(), use.shape)
        raise MotionError(
            f"joint {joint + 1} needs {needed[i, joint]:.4g} N m to hold the arm on the path, "
            f"{abs(gravity[i, joint]):.4g} N m for gravity and {abs(friction[i, joint]):.4g} N m "
            f"for friction; {effort[joint]:.4g} N m are allowed, "
            f"{100.0 * EFFORT_FRACTION:.0f} % of its limit",
            reason="effort",
        )
