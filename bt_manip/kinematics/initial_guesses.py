"""Where searches start when the first start was in vain."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .task import Task

DRAWN = 400  # configurations to choose starts from
APART = 1.2  # [rad], root mean square: starts that are nearer than this tend to end alike
CLOSER = 0.7  # of it, when no start is left that far from those before


class InitialGuesses:
    """Configurations that are near to meeting a task.

    For poses of the tool they are chosen from configurations that were drawn once, with the poses
    that the tool has there; for other tasks they are drawn anew.

    Attributes:
        stored: What was drawn once.  # (n, nq)
    """

    def __init__(self, arm: RobotModel, count: int, rng: np.random.Generator) -> None:
        """Draw configurations inside the limits.

        Args:
            arm: The arm; its data are written to.
            count: How many.
            rng: What they are drawn from.
        """
        lower, upper = within_a_turn(arm.limits.lower, arm.limits.upper)
        self.stored = rng.uniform(lower, upper, (count, arm.nq))
        poses = [arm.pose(q) for q in self.stored]
        position = np.array([T.translation for T in poses])
        self._place = np.column_stack([-2.0 * position, (position**2).sum(axis=1)])
        self._quat = np.array([pin.Quaternion(T.rotation).coeffs() for T in poses])

    def nearest(self, task: Task, n: int, rng: np.random.Generator | None = None) -> np.ndarray:
        """Give configurations near to meeting a task, nearest first.

        Args:
            task: What is searched for.
            n: How many.
            rng: What they are drawn from if they are; by default a new generator.
        """
        if task.tool_pose is None:  # (n, nq)
            return _drawn(task, n, np.random.default_rng(0) if rng is None else rng)
        near = self.stored[self._nearest_poses(task.tool_pose, n)]
        return np.minimum(np.maximum(near, task.lower), task.upper)

    def spread(
        self, task: Task, n: int, rng: np.random.Generator | None = None
    ) -> Iterator[np.ndarray]:
        """Give configurations near to meeting a task, each far from those before it.

        Where one descent ended in a corner of the limits, its neighbours do too.

        Args:
            task: What is searched for.
            n: How many.
            rng: As for `nearest`.
        """
        near = self.nearest(task, DRAWN, rng)
        square, doubled = (near * near).mean(axis=1), near * (2.0 / near.shape[1])
        left = np.full(len(near), np.inf)  # mean square distance to the nearest one given
        apart = APART**2
        for _ in range(min(n, len(near))):
            while left[chosen := int((left >= apart).argmax())] < apart:
                apart *= CLOSER**2
            yield near[chosen]
            away = square + square[chosen] - doubled.dot(near[chosen])
            left = np.minimum(left, np.maximum(away, 0.0))  # rounding makes it negative
            left[chosen] = -1.0

    def _nearest_poses(self, T_wt: pin.SE3, n: int) -> np.ndarray:
        # Squared distance and squared sine of half the angle, but for what all have in common.
        cosine = self._quat.dot(pin.Quaternion(T_wt.rotation).coeffs())
        far = self._place.dot(np.append(T_wt.translation, 1.0)) - cosine * cosine
        n = min(n, len(far))
        chosen = np.argpartition(far, n - 1)[:n]
        return chosen[np.argsort(far[chosen], kind="stable")]


def _drawn(task: Task, n: int, rng: np.random.Generator) -> np.ndarray:
    lower, upper = within_a_turn(task.lower, task.upper)
    drawn = rng.uniform(lower, upper, (DRAWN, len(lower)))
    far = np.empty(DRAWN)
    for i, q in enumerate(drawn):
        error = task.system.look(q)
        far[i] = error.dot(error)
    return drawn[np.argsort(far, kind="stable")[:n]]


def within_a_turn(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bound joints that turn farther than once, or for ever, to half a turn each way."""
    least = np.where(upper < -np.pi, lower, np.maximum(lower, -np.pi))
    most = np.where(lower > np.pi, upper, np.minimum(upper, np.pi))
    return least, most
