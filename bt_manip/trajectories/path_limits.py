"""What the limits of an arm leave for driving a path: linear in ``z = ds^2`` and ``u = dds``."""

import numpy as np

from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel

from .curve_efforts import CurveEfforts
from .kinematic_limits import KinematicLimits
from .paths import Path

DAMPED = 0.9  # of what is left of an effort for moving, the most that damping may take
LITTLE = 0.05  # of an effort: whether damping takes it or not makes no difference
_TINY = 1e-9


class PathLimits:
    """The limits along a path: ``-below <= rates u + squares z <= above`` at each point.

    Attributes:
        fastest: The greatest ``ds`` that the velocities allow.  # (n,)
        rates: What multiplies u.  # (n, k)
        squares: What multiplies z.  # (n, k)
    """

    def __init__(
        self,
        path: Path,
        places: np.ndarray,
        bounds: KinematicLimits,
        model: RobotModel | None,
        allowed: float,
    ) -> None:
        """Look at a path.

        Args:
            path: The curve.
            places: Where.  # (n,)
            bounds: Limits of its coordinates.
            model: The arm with its payload; None does not mind efforts.
            allowed: Fraction of every effort limit that may be used.

        Raises:
            MotionError: When the arm cannot even stand on the path.
        """
        x, d1, d2 = path.evaluate(places, 2)
        velocity = np.tile(bounds.velocity, (len(d1), 1))
        self.rates, self.squares = d1, d2
        self._acceleration = np.broadcast_to(bounds.acceleration, d1.shape)
        self._efforts: _Efforts | None = None
        if model is not None:
            efforts = self._efforts = _Efforts(x, d1, d2, model, allowed)
            velocity[:, : path.nq] = np.minimum(velocity[:, : path.nq], efforts.velocity)
            self.rates = np.hstack([self.rates, efforts.rates])
            self.squares = np.hstack([self.squares, efforts.squares])
        self.fastest = (velocity / (np.abs(d1) + _TINY)).min(axis=1)

    @property
    def damped(self) -> bool:
        """Whether damping takes more than a little of any effort."""
        return self._efforts is not None and self._efforts.damped

    def constants(self, speed: np.ndarray) -> np.ndarray:
        """Give above and below, when damping takes what it does at a speed ``ds``."""
        sides = self._acceleration[np.newaxis].repeat(2, axis=0)
        if self._efforts is not None:
            sides = np.concatenate([sides, self._efforts.left(speed)], axis=-1)
        return sides  # (2, n, k)


class _Efforts:
    """The same for the efforts of an arm.

    Attributes:
        velocity: The greatest that damping leaves.  # (n, nq)
        rates: What multiplies u.  # (n, nq)
        squares: What multiplies z.  # (n, nq)
        damped: Whether damping takes more than a little of any effort.
    """

    def __init__(
        self, x: np.ndarray, d1: np.ndarray, d2: np.ndarray, model: RobotModel, allowed: float
    ) -> None:
        """Look at a path at some points.

        Raises:
            MotionError: When the arm cannot even stand on the path.
        """
        at = CurveEfforts.along(model, x, d1, d2)
        v, gravity = d1[:, : model.nq], at.gravity
        effort = allowed * model.limits.effort
        spare = effort - model.friction - np.abs(gravity)
        if (spare <= 0.0).any():
            i, joint = np.argwhere(spare <= 0.0)[0]
            raise MotionError(
                f"joint {joint + 1} needs {abs(gravity[i, joint]):.1f} N m to stand on the way; "
                f"{effort[joint]:.1f} N m are allowed, friction included",
                reason="effort",
            )
        # Some models' damping takes all the effort that gravity leaves or adds before the joint is
        # at full speed.
        moving = effort - model.friction - np.sign(v) * gravity
        self.velocity = DAMPED * moving / (model.damping + _TINY)
        self.damped = bool((model.damping * model.limits.velocity > LITTLE * effort).any())
        self.rates, self.squares = at.rates, at.squares
        self._effort, self._gravity = effort, gravity
        self._friction, self._damping = at.friction, at.linear

    def left(self, speed: np.ndarray) -> np.ndarray:
        """Give what is left above and below, when damping takes what it does at a speed."""
        lost = self._gravity + self._friction + self._damping * speed[:, np.newaxis]
        return np.stack([self._effort - lost, self._effort + lost])  # (2, n, nq)
