"""The fastest way to drive a path.

Time-optimal path parametrisation by reachability, after H. Pham and Q.-C. Pham, "A New Approach to
Time-Optimal Path Parameterization Based on Reachability Analysis", IEEE T-RO 34 (2018): with
``z = ds^2`` and ``u = dds`` every limit on acceleration and effort is linear in u and z. The
acceleration of the result jumps; it is averaged over a few milliseconds, and the whole is slowed by
the little that this costs.
"""

from collections.abc import Sequence

import numpy as np

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .errors import MotionError
from .jerk_profile import JerkProfile, reach_profile
from .paths import Path

GRIDS = (120, 360)  # intervals; the finer one for a curvature that the first is too coarse for
NODE = 6e-3  # [s] acceleration is linear between nodes, and averaged over two of these
MOST_NODES = 250
MARGIN = 0.99  # of the limits, for what smoothing shifts
DAMPED = 0.5  # of what is left of an effort for moving, the most that damping may take
_TINY = 1e-9
_STUCK = 1e-3


def time_optimal(
    path: Path,
    bounds: Bounds,
    model: RobotModel,
    allowed: float,
    grids: Sequence[int] = GRIDS,
) -> JerkProfile:
    """Plan the path parameter from rest at 0 to rest at 1, close to as fast as it goes.

    Args:
        path: The curve.
        bounds: Limits of its coordinates.
        model: The arm with its payload.
        allowed: Fraction of every effort limit that may be used.
        grids: Intervals that it is looked at in; a finer one where the path bends too much for
            the first.

    Raises:
        MotionError: When the arm cannot even stand on the path.
    """
    for grid in grids:
        s = np.linspace(0.0, 1.0, grid + 1)
        x, d1, d2 = path.evaluate(s, 2)
        velocity, rates, squares, constants = _constraints(
            x, d1, d2, path.nq, bounds, model, allowed
        )
        most = (MARGIN * velocity / (np.abs(d1) + _TINY)).min(axis=1) ** 2
        speed = np.sqrt(_fastest(rates, squares, constants, most))
        if speed[1:-1].min() >= _STUCK * speed.max():
            return _smoothed(s, speed)
    return _unhurried(d1, bounds)


def _unhurried(d1: np.ndarray, bounds: Bounds) -> JerkProfile:
    """Plan as if the path were straight: the caller slows it to what its curvature allows."""
    slope = np.abs(d1).max(axis=0) + _TINY
    least = [float((bound / slope).min()) for bound in bounds]
    return reach_profile((0.0, 0.0, 0.0), 1.0, (least[0], least[1], least[2]))


def _constraints(
    x: np.ndarray,
    d1: np.ndarray,
    d2: np.ndarray,
    nq: int,
    bounds: Bounds,
    model: RobotModel,
    allowed: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Give each point's greatest velocity and its limits ``rates u + squares z <= constants``."""
    still = np.zeros(nq)
    gravity = np.array([model.rnea(q[:nq], still, still) for q in x])
    inertia = np.array([model.rnea(q[:nq], still, v[:nq]) for q, v in zip(x, d1, strict=True)])
    motion = np.array(
        [model.rnea(q[:nq], v[:nq], a[:nq]) for q, v, a in zip(x, d1, d2, strict=True)]
    )
    # Friction is counted in full and damping at full speed, both against the motion. Full speed is
    # what leaves something to accelerate with: some models' damping takes all efforts there are.
    free = allowed * model.limits.effort - model.friction
    spare = np.maximum(free - np.abs(gravity), 0.0)
    velocity = np.tile(bounds.velocity, (len(x), 1))
    velocity[:, :nq] = np.minimum(velocity[:, :nq], DAMPED * spare / (model.damping + _TINY))
    free = free - model.damping * velocity[:, :nq]
    if (np.abs(gravity) >= free).any():
        i, joint = np.argwhere(np.abs(gravity) >= free)[0]
        raise MotionError(
            f"joint {joint + 1} needs {abs(gravity[i, joint]):.1f} N m to stand on the way; "
            f"{allowed * model.limits.effort[joint]:.1f} N m are allowed, friction included",
            reason="effort",
        )
    rates = np.hstack([d1, inertia - gravity])
    squares = np.hstack([d2, motion - gravity])
    acceleration = np.broadcast_to(MARGIN * bounds.acceleration, d1.shape)
    above = np.hstack([acceleration, MARGIN * free - gravity])
    below = np.hstack([acceleration, MARGIN * free + gravity])
    return (
        velocity,
        np.hstack([rates, -rates]),
        np.hstack([squares, -squares]),
        np.maximum(np.hstack([above, below]), _TINY),
    )


def _fastest(
    rates: np.ndarray, squares: np.ndarray, constants: np.ndarray, most: np.ndarray
) -> np.ndarray:
    """Give the greatest ``ds^2`` at each point of the grid."""  # (n,)
    n = len(most)
    h = 1.0 / (n - 1)
    # u <= slope z + offset where the rate is positive, u >= where it is negative
    positive, negative = rates > _TINY, rates < -_TINY
    safe = np.where(positive | negative, rates, 1.0)
    slope, offset = -squares / safe, constants / safe
    flat = ~(positive | negative) & (squares > _TINY)
    most = np.minimum(most, np.where(flat, constants / np.where(flat, squares, 1.0), np.inf).min(1))
    most = _admissible(slope, offset, positive, negative, most)
    last = np.zeros(n)  # the greatest from which the end can still be reached
    for i in range(n - 2, -1, -1):
        rise = 1.0 + 2.0 * h * slope[i]
        binds = negative[i] & (rise > _TINY)
        limit = (last[i + 1] - 2.0 * h * offset[i])[binds] / rise[binds]
        last[i] = max(0.0, min(float(limit.min(initial=np.inf)), float(most[i])))
    z = np.zeros(n)
    for i in range(n - 1):
        up = slope[i] * z[i] + offset[i]
        z[i + 1] = min(z[i] + 2.0 * h * float(up[positive[i]].min(initial=np.inf)), last[i + 1])
    return np.maximum(z, 0.0)


def _admissible(
    slope: np.ndarray,
    offset: np.ndarray,
    positive: np.ndarray,
    negative: np.ndarray,
    most: np.ndarray,
) -> np.ndarray:
    """Lower ``most`` to where some acceleration is still allowed, by bisection."""
    low, high = np.zeros_like(most), most.copy()
    trial = high
    for _ in range(30):
        bound = slope * trial[:, np.newaxis] + offset
        most_u = np.where(positive, bound, np.inf).min(axis=1)
        least_u = np.where(negative, bound, -np.inf).max(axis=1)
        fits = least_u <= most_u
        low, high = np.where(fits, trial, low), np.where(fits, high, trial)
        trial = np.where(low >= most, most, 0.5 * (low + high))
    return low


def _smoothed(s: np.ndarray, speed: np.ndarray) -> JerkProfile:
    """Average the acceleration over two nodes and make it linear between them."""
    steps = 2.0 * np.diff(s) / np.maximum(speed[1:] + speed[:-1], _TINY)
    t = np.concatenate([[0.0], np.cumsum(steps)])
    node = max(NODE, t[-1] / MOST_NODES)
    n = int(np.ceil(t[-1] / node))
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
