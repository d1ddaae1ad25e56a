"""Where searches start when the first start was in vain."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .task import Task

DRAWN = 400  # configurations to choose starts from


class StoredStarts:
    """Configurations drawn once, with the poses of the tool at them."""

    def __init__(self, arm: RobotModel, count: int, rng: np.random.Generator) -> None:
        """Draw configurations inside the limits.

        Args:
            arm: The arm; its data are written to.
            count: How many.
            rng: What they are drawn from.
        """
        lower, upper = within_a_turn(arm.limits.lower, arm.limits.upper)
        self.q = rng.uniform(lower, upper, (count, arm.nq))
        poses = [arm.pose(q) for q in self.q]
        self._position = np.array([T.translation for T in poses])
        self._quat = np.array([pin.Quaternion(T.rotation).coeffs() for T in poses])

    def nearest(self, T_wt: pin.SE3, n: int) -> np.ndarray:
        """Give those whose tool is nearest to a pose, nearest first."""  # (n, nq)
        cosine = self._quat @ pin.Quaternion(T_wt.rotation).coeffs()
        offset = self._position - T_wt.translation
        far = (offset * offset).sum(axis=1) + 1.0 - cosine * cosine
        n = min(n, len(far))
        chosen = np.argpartition(far, n - 1)[:n]
        return self.q[chosen[np.argsort(far[chosen], kind="stable")]]


def drawn_starts(task: Task, n: int, rng: np.random.Generator) -> np.ndarray:
    """Draw configurations and give those that are nearest to meeting a task, nearest first.

    Args:
        task: What is searched for.
        n: How many starts.
        rng: What they are drawn from.
    """  # (n, nq)
    lower, upper = within_a_turn(task.lower, task.upper)
    drawn = rng.uniform(lower, upper, (DRAWN, len(lower)))
    far = np.empty(DRAWN)
    for i, q in enumerate(drawn):
        task.system.look(q)
        error = task.system.error
        far[i] = error.dot(error)
    return drawn[np.argsort(far, kind="stable")[:n]]


def within_a_turn(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bound joints that turn farther than once, or for ever, to half a turn each way."""
    least = np.where(upper < -np.pi, lower, np.maximum(lower, -np.pi))
    most = np.where(lower > np.pi, upper, np.minimum(upper, np.pi))
    return least, most
