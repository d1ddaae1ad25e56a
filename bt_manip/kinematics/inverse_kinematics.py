"""Inverse kinematics: configurations for poses of the tool, and for problems."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import chain
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import shown
from bt_manip.robots import (
    RobotModel,
    check_configuration,
    check_count,
    check_generator,
    check_non_negative,
    check_pose,
    check_positive,
    invalid,
)

from .compiled_problem import CompiledProblem, compile_problem
from .initial_guesses import InitialGuesses
from .levenberg_marquardt import LMResult
from .maximum_reach import MaximumReach
from .problem import IKProblem, IKResult
from .residuals import PoseResidual, StackedResidual
from .search import refined_end, search, search_all, search_near
from .secondary_objectives import SecondaryObjectives
from .targets import TOLERANCE, Target

RESTARTS = 80  # maximum number of initial guesses after the first
DISTINCT = 0.1  # [rad] minimum difference of two solutions in some joint

Request: TypeAlias = pin.SE3 | Target | IKProblem
"""A pose T_wt of the tool in the world, a target of a frame, or a problem."""


class InverseKinematics:
    """Inverse kinematics within the joint limits, by bounded searches.

    A request is a pose of the tool, a target, or an `IKProblem`. Levenberg-Marquardt starts from
    the given configuration, then from initial guesses with a small residual, far from each other.
    For poses of the tool, also with free rotations, these are selected from stored samples; for
    other problems they are sampled with the given generator. So the same request has the same
    result. A solution is then moved to a local minimum of the problem's cost.

    Args:
        model: The arm; a copy is kept.

    Attributes:
        model: The arm.
        tool: Name of the frame of a pose without a target.

    Raises:
        MotionError: If it is not a `RobotModel`.
    """

    def __init__(self, model: RobotModel) -> None:
        if not isinstance(model, RobotModel):
            raise invalid(
                f"model must be a RobotModel (Robot.make_model), got {type(model).__name__}"
            )
        self.model = model.copy()
        self._accepted = self.model.tolerance.position, self.model.tolerance.rotation
        self._inverse_speed = 1.0 / model.limits.velocity
        self._initial_guesses = InitialGuesses(self.model)
        self._reach = MaximumReach(self.model, self._initial_guesses.stored)
        tool = self.model.tool_frame_id
        self.tool = str(self.model.model.frames[tool].name)
        self._tool_residual = PoseResidual(
            self.model, tool, self.model.pose(self.model.home), (TOLERANCE, TOLERANCE)
        )
        self._tool_constraint = StackedResidual(self.model, [self._tool_residual])
        self._joints = tuple(self.model.model.names)[1:]

    def solve(
        self,
        request: Request,
        q0: np.ndarray,
        *,
        restarts: int = RESTARTS,
        rng: np.random.Generator | None = None,
    ) -> IKResult:
        """Return one configuration.

        Args:
            request: A pose of the tool, a target, or a problem.
            q0: The first initial guess, clipped to the limits.  # (nq,)
            restarts: Maximum number of further initial guesses.
            rng: Random generator for further initial guesses of a problem; by default a new one,
                so that the same request has the same result.

        Returns:
            The solution, or the configuration with the smallest residual; for a problem without
            constraints, the lowest cost from several initial guesses.

        Raises:
            MotionError: If an argument is invalid.
        """
        q0 = self._clipped(q0)
        restarts = check_count(restarts, "restarts")
        rng = None if rng is None else check_generator(rng)
        problem = self._compile(request, q0)
        first = np.minimum(np.maximum(q0, problem.lower), problem.upper)
        excess = self._out_of_reach(problem)
        if excess:
            reason = f"{excess:.3f} m out of reach"
            return IKResult(first, False, problem.errors(first), 0, reason=reason)
        others = self._initial_guesses.spread(problem, restarts, rng) if restarts else ()
        return search(problem, chain([first], others))

    def follow(
        self,
        request: Request,
        q0: np.ndarray,
        *,
        max_step: float = 0.2,
        retry: bool = True,
        margin: float = 0.0,
        tolerance: float | None = None,
    ) -> IKResult:
        """Return a configuration near `q0`.

        Args:
            request: A pose of the tool, a target, or a problem.
            q0: The previous configuration.  # (nq,)
            max_step: Maximum change of each joint [rad].
            retry: Whether to try other initial guesses within `max_step`.
            margin: Distance from the limits for a pose [rad]; as in a problem, it applies to the
                joints that have it at `q0`.
            tolerance: Desired error for a pose [m] and [rad]; by default `TOLERANCE`.

        Raises:
            MotionError: If an argument is invalid, a margin is given with a problem, or a tolerance
                with a problem or a target.
        """
        q0 = check_configuration(q0, self.model.nq)
        check_positive(max_step, "max_step", "rad")
        check_non_negative(margin, "margin", "rad")
        if tolerance is not None:
            check_positive(tolerance, "tolerance", "m, rad")
        if not isinstance(retry, bool | np.bool_):
            raise invalid(f"retry must be True or False, got {shown(retry)}")
        problem = self._compile(request, q0, margin, tolerance)
        return search_near(problem, q0, max_step=max_step, retry=retry)

    def solutions(
        self,
        request: Request | Sequence[pin.SE3 | Target],
        q0: np.ndarray,
        *,
        restarts: int = 8,
        margin: float = 0.0,
        rng: np.random.Generator | None = None,
    ) -> list[IKResult]:
        """Return distinct solutions, the best first; in some joint they differ by `DISTINCT`.

        Solutions of a problem with costs are sorted by cost. Others are moved to the minimum of
        their `distance` from `q0` and sorted by it.

        Args:
            request: A pose of the tool or a target, several alternatives, or a problem.
            q0: The present configuration.  # (nq,)
            restarts: Number of initial guesses after `q0`, for each pose.
            margin: Distance from the limits for poses and targets [rad]; there are no solutions if
                it leaves a joint no range.
            rng: Random generator for initial guesses of a problem; by default a new one.

        Raises:
            MotionError: If an argument is invalid, or a margin is given with a problem.
        """
        q0 = self._clipped(q0)
        rng = None if rng is None else check_generator(rng)
        found: list[tuple[float, IKResult]] = []
        for i, problem, ends in self._search_all(_alternatives(request), q0, restarts, margin, rng):
            searched = self._with_nearness(problem, q0)
            for end in ends:
                refined = refined_end(searched, end)
                if refined is not None:
                    cost = refined.cost if problem.objectives else 0.0
                    found.append((refined.cost, refined._replace(target=i, cost=cost)))
        found.sort(key=lambda pair: pair[0])
        return list(_distinct(result for _, result in found))

    def nearest_first(
        self,
        targets: pin.SE3 | Target | Sequence[pin.SE3 | Target],
        q0: np.ndarray,
        *,
        restarts: int = 8,
        margin: float = 0.0,
    ) -> Iterator[IKResult]:
        """Yield distinct solutions, approximately the nearest to `q0` first.

        Like `solutions`, but each is moved to its minimum of the distance only when it is
        requested; the order is that of their distances before.

        Args:
            targets: A pose of the tool or a target, or several alternatives.
            q0: The present configuration.  # (nq,)
            restarts: Number of initial guesses after `q0`, for each pose.
            margin: Distance from the limits [rad].

        Raises:
            MotionError: If an argument is invalid.
        """
        q0 = self._clipped(q0)
        poses = _alternatives(targets)
        found = [
            (self.distance(end.q, q0), i, end)
            for i, _, ends in self._search_all(poses, q0, restarts, margin, None)
            for end in ends
        ]
        found.sort(key=lambda one: one[0])

        def refine_one_by_one() -> Iterator[IKResult]:
            for _, i, end in found:
                problem = self._compile(poses[i], q0, margin)
                refined = refined_end(self._with_nearness(problem, q0), end)
                if refined is not None:
                    yield refined._replace(target=i, cost=0.0)

        return _distinct(refine_one_by_one())

    def nearest(
        self,
        targets: pin.SE3 | Target | Sequence[pin.SE3 | Target],
        q0: np.ndarray,
        *,
        margin: float = 0.0,
    ) -> IKResult:
        """Return the solution nearest to `q0` for one pose or several alternatives.

        Args:
            targets: A pose of the tool or a target, or several alternatives.
            q0: The present configuration.  # (nq,)
            margin: Distance from the limits, if possible [rad].

        Raises:
            MotionError: If an argument is invalid.
        """
        poses = _alternatives(targets)
        margin = check_non_negative(margin, "margin", "rad")
        for bound in (margin, 0.0) if margin > 0.0 else (0.0,):
            found = self.solutions(poses, q0, restarts=max(2, 8 // len(poses)), margin=bound)
            if found:
                return found[0]
        last = [self.solve(T, q0) for T in poses]
        solved = [i for i, result in enumerate(last) if result.solved]
        if solved:
            i = min(solved, key=lambda i: self.distance(last[i].q, q0))
        else:
            i = min(range(len(last)), key=lambda i: last[i].position_error)
        iterations = sum(result.iterations for result in last)
        return last[i]._replace(iterations=iterations, target=i)

    def distance(self, q: np.ndarray, q0: np.ndarray) -> float:
        """Return the root mean square over the joints of the time at maximum velocity [s]."""
        times = (q - q0) * self._inverse_speed
        return float(np.sqrt(times.dot(times) / len(times)))

    def _search_all(
        self,
        requests: Sequence[Request],
        q0: np.ndarray,
        restarts: int,
        margin: float,
        rng: np.random.Generator | None,
    ) -> Iterator[tuple[int, CompiledProblem, list[LMResult]]]:
        """Yield index, compiled problem and unrefined solutions of each request within reach."""
        check_count(restarts, "restarts")
        check_non_negative(margin, "margin", "rad")
        for i, request in enumerate(requests):
            problem = self._compile(request, q0, margin)
            if not self._out_of_reach(problem) and (problem.lower <= problem.upper).all():
                guesses = self._near_guesses(problem, q0, restarts, rng)
                yield i, problem, search_all(problem, guesses)

    def _with_nearness(self, problem: CompiledProblem, q0: np.ndarray) -> CompiledProblem:
        """Return a problem whose cost, if it has none, is the squared distance from `q0`."""
        if problem.objectives:
            return problem
        nearness = SecondaryObjectives(self._inverse_speed, posture=(q0, 1.0))
        return problem._replace(objectives=nearness)

    def _clipped(self, q: np.ndarray) -> np.ndarray:
        q = check_configuration(q, self.model.nq)
        return np.minimum(np.maximum(q, self.model.limits.lower), self.model.limits.upper)

    def _compile(
        self,
        request: Request,
        q0: np.ndarray,
        margin: float = 0.0,
        tolerance: float | None = None,
    ) -> CompiledProblem:
        if isinstance(request, (IKProblem, Target)):
            return self._compile_problem(request, q0, margin, tolerance)
        aimed = TOLERANCE if tolerance is None else tolerance
        self._tool_residual.set_target(check_pose(request), (aimed, aimed), self._accepted)
        constraint = self._tool_constraint
        constraint.q = None
        lower, upper = self.model.limits.lower, self.model.limits.upper
        if margin:
            lower, upper = lower + margin, upper - margin
        frames, residuals = (self.tool,), ((self._tool_residual,),)
        return CompiledProblem(
            constraint, lower, upper, self._joints, frames, residuals, None, request
        )

    def _compile_problem(
        self, request: IKProblem | Target, q0: np.ndarray, margin: float, tolerance: float | None
    ) -> CompiledProblem:
        if tolerance is not None:
            raise invalid(
                "each target of a problem has its own tolerance: ask for "
                f"PoseTarget(tolerance=...), got tolerance={tolerance!r} beside a problem"
            )
        if isinstance(request, IKProblem):
            if margin:
                raise invalid(
                    "a problem has its own margin: ask for IKProblem(margin=...), "
                    f"got margin={margin!r} beside a problem"
                )
            return compile_problem(self.model, self._joints, request, q0, self._inverse_speed)
        if request.weight is not None:
            raise invalid(f"the {request.label} is a cost: ask for IKProblem(targets=[...])")
        problem = self._compile(IKProblem(targets=[request]), q0)
        return problem._replace(lower=problem.lower + margin, upper=problem.upper - margin)

    def _out_of_reach(self, problem: CompiledProblem) -> float:
        return 0.0 if problem.tool_target is None else self._reach.excess(problem.tool_target)

    def _near_guesses(
        self,
        problem: CompiledProblem,
        q0: np.ndarray,
        restarts: int,
        rng: np.random.Generator | None,
    ) -> Iterator[np.ndarray]:
        """Yield `q0`, then the initial guesses with small residuals that are nearest to it."""
        yield np.minimum(np.maximum(q0, problem.lower), problem.upper)
        if restarts > 0:
            guesses = self._initial_guesses.nearest(problem, 8 * restarts, rng)
            distances = [self.distance(q, q0) for q in guesses]
            yield from guesses[np.argsort(distances, kind="stable")[:restarts]]


def _alternatives(request: Request | Sequence[pin.SE3 | Target]) -> list[Request]:
    """Return one or several alternative requests as a list."""
    requests = list(request) if isinstance(request, list | tuple) else [request]
    if not requests:
        raise invalid("no target pose was given")
    for alternative in requests:
        if not isinstance(alternative, IKProblem | Target):
            check_pose(alternative)
    return requests


def _distinct(results: Iterable[IKResult]) -> Iterator[IKResult]:
    """Yield results that differ from all previous ones by more than `DISTINCT` in some joint."""
    kept: list[np.ndarray] = []
    for result in results:
        if all(np.abs(result.q - q).max() > DISTINCT for q in kept):
            kept.append(result.q)
            yield result
