"""Initial guesses for restarts."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel, sampling_bounds

from .compiled_problem import CompiledProblem
from .targets import PoseTarget

STORED = 2000  # number of stored configurations
CANDIDATES = 400  # nearest configurations from which initial guesses are chosen
SPREAD = 1.2  # [rad] RMS distance below which two initial guesses tend to converge alike
SPREAD_REDUCTION = 0.7  # factor on the spread when no candidate has it


class InitialGuesses:
    """Configurations with a small residual of a problem.

    For poses of the tool, guesses are stored random configurations, selected by their tool poses;
    for other problems, new random configurations, selected by their residuals.

    Args:
        arm: The arm; its data are written to.

    Attributes:
        stored: The stored configurations.  # (n, nq)
    """

    def __init__(self, arm: RobotModel) -> None:
        lower, upper = arm.limits.sampling_bounds()
        self.stored = np.random.default_rng(0).uniform(lower, upper, (STORED, arm.nq))
        poses = [arm.pose(q) for q in self.stored]
        self._rotation = np.array([T.rotation for T in poses])
        self._origin = position = np.array([T.translation for T in poses])
        self._position = np.column_stack([-2.0 * position, (position**2).sum(axis=1)])
        self._quat = np.array([pin.Quaternion(T.rotation).coeffs() for T in poses])

    def nearest(
        self, problem: CompiledProblem, n: int, rng: np.random.Generator | None = None
    ) -> np.ndarray:
        """Return the n configurations with the smallest residuals, the smallest first.

        Args:
            problem: The problem.
            n: Number of configurations.
            rng: Random generator for new configurations; by default a new one.
        """  # (n, nq)
        target = problem.tool_target
        if target is None:
            return _draw(problem, n, np.random.default_rng(0) if rng is None else rng)
        if isinstance(target, PoseTarget):
            distance = self._distance(target)
        else:
            # Squared distance plus squared sine of half the angle, up to a common constant.
            cosine = self._quat.dot(pin.Quaternion(target.rotation).coeffs())
            distance = self._position.dot(np.append(target.translation, 1.0)) - cosine * cosine
        n = min(n, len(distance))
        chosen = np.argpartition(distance, n - 1)[:n]
        near = self.stored[chosen[np.argsort(distance[chosen], kind="stable")]]
        return np.minimum(np.maximum(near, problem.lower), problem.upper)

    def _distance(self, target: PoseTarget) -> np.ndarray:
        """Return squared distance plus squared sine of half the angle outside the cone."""
        pivot, axis = np.asarray(target.pivot), np.asarray(target.free_axis)
        offset = self._origin + self._rotation.dot(pivot) - target.pose.act(pivot)
        cosine = self._rotation.dot(axis).dot(target.pose.rotation.dot(axis))
        outside = np.maximum(np.arccos(np.clip(cosine, -1.0, 1.0)) - target.cone, 0.0)
        return np.asarray((offset**2).sum(axis=1) + np.sin(0.5 * outside) ** 2)

    def spread(
        self, problem: CompiledProblem, n: int, rng: np.random.Generator | None = None
    ) -> Iterator[np.ndarray]:
        """Yield configurations with a small residual, each far from all previous ones.

        Args:
            problem: The problem.
            n: Maximum number of configurations.
            rng: Random generator for new configurations; by default a new one.
        """
        near = self.nearest(problem, CANDIDATES, rng)
        square, doubled = (near * near).mean(axis=1), near * (2.0 / near.shape[1])
        distance = np.full(len(near), np.inf)  # mean square distance to the nearest previous guess
        required = SPREAD**2
        for _ in range(min(n, len(near))):
            while distance[chosen := int((distance >= required).argmax())] < required:
                required *= SPREAD_REDUCTION**2
            yield near[chosen]
            to_chosen = square + square[chosen] - doubled.dot(near[chosen])
            distance = np.minimum(distance, np.maximum(to_chosen, 0.0))  # rounding may give < 0
            distance[chosen] = -1.0


def _draw(problem: CompiledProblem, n: int, rng: np.random.Generator) -> np.ndarray:
    lower, upper = sampling_bounds(problem.lower, problem.upper)
    drawn = rng.uniform(lower, upper, (CANDIDATES, len(lower)))
    squared = np.empty(CANDIDATES)
    for i, q in enumerate(drawn):
        error = problem.constraints.evaluate(q)
        squared[i] = error.dot(error)
    return drawn[np.argsort(squared, kind="stable")[:n]]
