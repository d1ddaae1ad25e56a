"""The fastest way to drive a path.

Time-optimal path parametrisation by reachability, after H. Pham and Q.-C. Pham, "A New Approach to
Time-Optimal Path Parameterization Based on Reachability Analysis", IEEE T-RO 34 (2018): with
``z = ds^2`` and ``u = dds`` every limit on acceleration and effort is linear in u and z. The
acceleration of the result jumps; it is averaged over a few milliseconds, or over as many as the
limits of jerk ask for, and the whole is slowed by the little that this costs.
"""

from collections.abc import Sequence

import numpy as np

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .errors import MotionError
from .jerk_profile import JerkProfile, reach_profile
from .paths import Path

GRIDS = (120, 360)  # intervals; the finer one for a curvature that the first is too coarse for
NODE = 6e-3  # [s] acceleration is linear between nodes, and averaged over two of these, at least
RAMPS = (0.25, 0.5, 1.0, 1.7)  # nodes, in the time in which a joint's full acceleration can come
MOST_NODES = 250
MARGIN = 0.99  # of the limits, for what smoothing shifts
DAMPED = 0.9  # of what is left of an effort for moving, the most that damping may take
LITTLE = 0.05  # of an effort: whether damping takes it or not makes no difference
ROUNDS = 8  # of the speed that damping is taken at, where it takes more
_TINY = 1e-9
_STUCK = 1e-3


def time_optimal(
    path: Path,
    bounds: Bounds,
    model: RobotModel | None,
    allowed: float,
    grids: Sequence[int] = GRIDS,
) -> list[JerkProfile]:
    """Plan the path parameter from rest at 0 to rest at 1, close to as fast as it goes.

    Args:
        path: The curve.
        bounds: Limits of its coordinates.
        model: The arm with its payload; None does not mind efforts.
        allowed: Fraction of every effort limit that may be used.
        grids: Intervals that it is looked at in; a finer one where the path bends too much for
            the first.

    Returns:
        Plans that are smoothed more and more: which of them is the fastest inside the limits of
        jerk is for the caller to see.

    Raises:
        MotionError: When the arm cannot even stand on the path.
    """
    ramp = float((bounds.acceleration / bounds.jerk)[: path.nq].max())
    nodes = sorted({max(NODE, part * ramp) for part in RAMPS})
    for grid in grids:
        s = np.linspace(0.0, 1.0, grid + 1)
        x, d1, d2 = path.evaluate(s, 2)
        limits = _Limits(d1, d2, bounds)
        if model is not None:
            limits.mind(_Efforts(x, d1, d2, model, allowed))
        most = (MARGIN * limits.velocity / (np.abs(d1) + _TINY)).min(axis=1) ** 2
        damped, speed = 0.5 * np.sqrt(most), np.sqrt(most)
        for _ in range(ROUNDS if limits.damped else 1):
            above, below = limits.constants(damped)
            speed = np.sqrt(_fastest(limits.rates, limits.squares, above, below, most))
            damped = 0.5 * (damped + speed)
        if speed[1:-1].min() >= _STUCK * speed.max():
            return [_smoothed(s, speed, node) for node in nodes]
    return [_unhurried(d1, bounds)]


def _unhurried(d1: np.ndarray, bounds: Bounds) -> JerkProfile:
    """Plan as if the path were straight: the caller slows it to what its curvature allows."""
    slope = np.abs(d1).max(axis=0) + _TINY
    least = [float((bound / slope).min()) for bound in bounds]
    return reach_profile((0.0, 0.0, 0.0), 1.0, (least[0], least[1], least[2]))


class _Limits:
    """The limits along a path: ``-below <= rates u + squares z <= above`` at each point.

    Attributes:
        velocity: The greatest of each coordinate.  # (n, m)
        rates: What multiplies u.  # (n, k)
        squares: What multiplies z.  # (n, k)
    """

    def __init__(self, d1: np.ndarray, d2: np.ndarray, bounds: Bounds) -> None:
        """Take those of the coordinates.

        Args:
            d1: First derivatives of the path at some points.  # (n, m)
            d2: Second derivatives.  # (n, m)
            bounds: Limits of the coordinates.
        """
        self.velocity = np.tile(bounds.velocity, (len(d1), 1))
        self.rates, self.squares = d1, d2
        self._acceleration = np.broadcast_to(MARGIN * bounds.acceleration, d1.shape)
        self._efforts: _Efforts | None = None

    def mind(self, efforts: "_Efforts") -> None:
        """Add those of the joints' efforts."""
        nq = efforts.rates.shape[1]
        self.velocity[:, :nq] = np.minimum(self.velocity[:, :nq], efforts.velocity)
        self.rates = np.hstack([self.rates, efforts.rates])
        self.squares = np.hstack([self.squares, efforts.squares])
        self._efforts = efforts

    @property
    def damped(self) -> bool:
        """Whether damping takes more than a little of any effort."""
        return self._efforts is not None and self._efforts.damped

    def constants(self, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give what is left for moving, when damping takes what it does at a speed ``ds``."""
        if self._efforts is None:
            return self._acceleration, self._acceleration
        efforts = self._efforts.left(speed)
        above, below = (np.hstack([self._acceleration, left]) for left in efforts)
        return np.maximum(above, _TINY), np.maximum(below, _TINY)  # (n, k) each


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
        nq = model.nq
        still = np.zeros(nq)
        q, v, a = x[:, :nq], d1[:, :nq], d2[:, :nq]
        gravity = np.array([model.rnea(row, still, still) for row in q])
        inertia = np.array([model.rnea(row, still, rate) for row, rate in zip(q, v, strict=True)])
        motion = np.array([model.rnea(*rows) for rows in zip(q, v, a, strict=True)])
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
        self.rates, self.squares = inertia - gravity, motion - gravity
        self._effort, self._gravity = MARGIN * effort, gravity
        self._friction, self._damping = model.friction * np.sign(v), model.damping * v

    def left(self, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Give what is left above and below, when damping takes what it does at a speed."""
        lost = self._gravity + self._friction + self._damping * speed[:, np.newaxis]
        return self._effort - lost, self._effort + lost  # (n, nq) each


def _fastest(
    rates: np.ndarray,
    squares: np.ndarray,
    above: np.ndarray,
    below: np.ndarray,
    most: np.ndarray,
) -> np.ndarray:
    """Give the greatest ``ds^2`` at each point of the grid."""  # (n,)
    n = len(most)
    h = 1.0 / (n - 1)
    # down <= u - slope z <= up; where the rate is next to nothing the limit is one of z
    steep = np.abs(rates) > _TINY
    safe = np.where(steep, rates, 1.0)
    slope = np.where(steep, -squares / safe, 0.0)
    ends = above / safe, -below / safe
    up = np.where(steep, np.maximum(*ends), np.inf)
    down = np.where(steep, np.minimum(*ends), -np.inf)
    flat = ~steep & (np.abs(squares) > _TINY)
    room = np.where(squares > 0.0, above, below) / np.where(flat, np.abs(squares), 1.0)
    most = np.minimum(most, np.where(flat, room, np.inf).min(axis=1))
    most = np.minimum(most, _admissible(slope, up, down))
    rise = 1.0 + 2.0 * h * slope
    binds = rise > _TINY
    share = np.where(binds, 1.0 / np.where(binds, rise, 1.0), 0.0)
    rest = np.where(binds, -2.0 * h * down * share, np.inf)
    last = np.zeros(n)  # the greatest from which the end can still be reached
    z, least = 0.0, np.minimum.reduce
    for i, bound in zip(range(n - 2, -1, -1), most[-2::-1].tolist(), strict=True):
        z = last[i] = max(0.0, min(float(least(z * share[i] + rest[i])), bound))
    fastest = np.zeros(n)
    gain, z = 2.0 * h * up, 0.0
    for i, bound in enumerate(last[1:].tolist()):
        z = fastest[i + 1] = max(0.0, min(float(least(z * rise[i] + gain[i])), bound))
    return fastest


def _admissible(slope: np.ndarray, up: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Give the greatest ``ds^2`` at which some acceleration is still allowed."""  # (n,)
    nearing = slope[:, np.newaxis, :] - slope[:, :, np.newaxis]
    apart = up[:, :, np.newaxis] - down[:, np.newaxis, :]
    meets = nearing > _TINY
    return np.where(meets, apart / np.where(meets, nearing, 1.0), np.inf).min(axis=(1, 2))


def _smoothed(s: np.ndarray, speed: np.ndarray, node: float) -> JerkProfile:
    """Average the acceleration over two nodes and make it linear between them."""
    steps = 2.0 * np.diff(s) / np.maximum(speed[1:] + speed[:-1], _TINY)
    t = np.concatenate([[0.0], np.cumsum(steps)])
    node = max(node, t[-1] / MOST_NODES)
    n = max(2, int(np.ceil(t[-1] / node)))  # one in the middle at least
    node = t[-1] / n
    nodes = node * np.arange(-2, n + 3)
    v = np.interp(nodes, t, speed, left=0.0, right=0.0)  # speed is linear in time between points
    a = np.zeros(n + 3)
    a[1:-1] = (v[3:-1] - v[1:-3]) / (2.0 * node)
    jerk = np.diff(a) / node
    velocity = np.concatenate([[0.0], np.cumsum(node * (a[1:] + a[:-1]) / 2.0)])
    moved = node * (velocity[:-1] + node * (a[:-1] / 2.0 + node * jerk / 6.0))
    position = np.concatenate([[0.0], np.cumsum(moved)])
    rows = np.column_stack(
        [
            node * np.arange(n + 2),
            np.column_stack([position[:-1], velocity[:-1], a[:-1], jerk]) / position[-1],
        ]
    )
    return JerkProfile(rows.tolist(), node * (n + 2), 1.0)
