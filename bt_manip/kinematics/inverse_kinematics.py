"""Inverse kinematics: configurations for poses of the tool, and for problems one states."""

from collections.abc import Iterator, Sequence
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from bt_manip.checks import (
    check_configuration,
    check_count,
    check_generator,
    check_non_negative,
    check_pose,
    check_poses,
    check_positive,
    invalid,
    shown,
)
from bt_manip.robots import RobotModel

from .initial_guesses import InitialGuesses
from .problem import IKProblem
from .reach import Reach
from .result import IKResult
from .rows import PoseRows
from .search import Found, search, search_all, search_near
from .secondary_objectives import Posture, SecondaryObjectives
from .self_motion import SelfMotion
from .system import System
from .targets import Target
from .task import Task, make_task

STORED = 2000  # configurations to restart from

Request: TypeAlias = pin.SE3 | IKProblem
"""A pose T_wt of the tool in the world, or a problem."""


class InverseKinematics:
    """Find joint configurations inside the limits, by bounded searches.

    A request is a pose of the tool, or an `IKProblem`. Levenberg-Marquardt goes from the start
    that is asked for; where it ends beside the targets, again from configurations that are near
    to meeting them and far from each other. For poses of the tool these were drawn once from a
    seeded generator, for other problems they are drawn from the generator that is handed in: the
    same request gives the same answer. A solution is moved along what its constraints leave free
    to where the problem's costs are least.

    Attributes:
        model: The arm.
        tool: Name of the frame that a pose alone is about.
    """

    def __init__(
        self,
        model: RobotModel,
        *,
        restarts: int = 80,
        iterations: int = 50,
        steps_in_vain: int = 600,
        seed: int = 0,
        position_tolerance: float = 1e-6,
        rotation_tolerance: float = 1e-6,
    ) -> None:
        """Prepare for an arm.

        Args:
            model: The arm; a copy is kept.
            restarts: InitialGuesses after the first, at the most.
            iterations: Steps from each start, at the most.
            steps_in_vain: Steps that led to no solution, over all starts, after which `solve`
                begins no other.
            seed: Of the stored configurations.
            position_tolerance: Of a solution for a pose [m].
            rotation_tolerance: Of a solution for a pose [rad].

        Raises:
            MotionError: When the arm is none, or a bound or a tolerance cannot be meant.
        """
        if not isinstance(model, RobotModel):
            raise invalid(
                f"model must be a RobotModel (Robot.make_model), got {type(model).__name__}"
            )
        self.model = model.copy()
        self.restarts = check_count(restarts, "restarts")
        self.iterations = check_count(iterations, "iterations")
        self.steps_in_vain = check_count(steps_in_vain, "steps_in_vain")
        self._tolerances = (
            check_positive(position_tolerance, "position_tolerance", "m"),
            check_positive(rotation_tolerance, "rotation_tolerance", "rad"),
        )
        chance = np.random.default_rng(check_count(seed, "seed"))
        self.self_motion = SelfMotion(self.model)
        self._inverse_speed = 1.0 / model.limits.velocity
        self._further = InitialGuesses(self.model, max(STORED, restarts), chance)
        self._reach = Reach(self.model, self._further.stored)
        tool = self.model.tool_frame_id
        self.tool = str(self.model.model.frames[tool].name)
        self._tool_rows = PoseRows(
            self.model, tool, self.model.pose(self.model.home), self._tolerances
        )
        self._tool_system = System(self.model, [self._tool_rows])
        self._joints = tuple(self.model.model.names)[1:]

    def solve(
        self,
        request: Request,
        q0: np.ndarray,
        *,
        restarts: int | None = None,
        rng: np.random.Generator | None = None,
    ) -> IKResult:
        """Find a configuration, the first from `q0` downhill.

        Args:
            request: A pose of the tool, or a problem.
            q0: Where to start; it is brought inside the limits.  # (nq,)
            restarts: InitialGuesses after the first, at the most; by default as constructed.
            rng: What further starts of a problem are drawn from; by default a new generator, so
                that the same request gives the same answer.

        Returns:
            The solution, or what came nearest. Of a problem without constraints, the least cost
            of several starts.

        Raises:
            MotionError: When the request, the start or another argument is none.
        """
        q0 = self._start(q0)
        count = self.restarts if restarts is None else check_count(restarts, "restarts")
        rng = None if rng is None else check_generator(rng)
        task = self._task(request, q0)
        start = np.minimum(np.maximum(q0, task.lower), task.upper)
        refused = self._refuse(task)
        if refused:
            return self._result(task, Found(start, False, reason=refused))
        starts = self._starts(task, start, count, rng)
        found = search(task, starts, self.iterations, self.steps_in_vain)
        return self._result(task, found)

    def follow(
        self,
        request: Request,
        q0: np.ndarray,
        *,
        max_step: float = 0.2,
        detours: bool = True,
        margin: float = 0.0,
        tolerance: float | None = None,
    ) -> IKResult:
        """Find the configuration near `q0`, without jumping and without restarts.

        Args:
            request: A pose of the tool, or a problem.
            q0: The configuration before.  # (nq,)
            max_step: How far a joint may go from it [rad].
            detours: Whether to try again from elsewhere inside `max_step`.
            margin: How far from the limits to stay for a pose [rad]; as that of a problem, it is
                kept once `q0` keeps it.
            tolerance: Of a solution for a pose [m] and [rad]; by default as constructed.

        Raises:
            MotionError: When the request, the configuration or another argument is none, or
                when a problem comes with a margin or a tolerance beside its own.
        """
        q0 = check_configuration(q0, self.model.nq)
        check_positive(max_step, "max_step", "rad")
        check_non_negative(margin, "margin", "rad")
        if tolerance is not None:
            check_positive(tolerance, "tolerance", "m, rad")
        if not isinstance(detours, bool | np.bool_):
            raise invalid(f"detours must be True or False, got {shown(detours)}")
        task = self._task(request, q0, margin, tolerance)
        found = search_near(task, q0, self.iterations, max_step=max_step, detours=detours)
        return self._result(task, found)

    def solutions(
        self,
        request: Request | Sequence[pin.SE3],
        q0: np.ndarray,
        *,
        starts: int = 8,
        margin: float = 0.0,
        distinct: float = 0.1,
        rng: np.random.Generator | None = None,
    ) -> list[IKResult]:
        """List distinct solutions, the best first.

        Those of a problem with costs or preferences are the better the less they cost. All others
        are moved along what their constraints leave free to where they are nearest to `q0`, and
        the nearest is the best. The distance is the time that the joints would need at their
        greatest speeds, root mean square (`distance`).

        Args:
            request: A pose of the tool, several that serve equally well, or a problem.
            q0: Where the arm is.  # (nq,)
            starts: How many further configurations to start from, for each pose.
            margin: How far from the limits solutions for poses stay [rad]; where it leaves a joint
                no room there are none.
            distinct: Solutions differ by more than this in some joint [rad].
            rng: As for `solve`.

        Raises:
            MotionError: When the request, the start or another argument is none, or when a
                problem comes with a margin beside its own.
        """
        q0 = self._start(q0)
        check_count(starts, "starts")
        check_non_negative(margin, "margin", "rad")
        check_non_negative(distinct, "distinct", "rad")
        rng = None if rng is None else check_generator(rng)
        nearest = SecondaryObjectives(self._inverse_speed, posture=Posture(q0, 1.0))
        ends: list[tuple[float, IKResult]] = []
        for i, task in enumerate(self._tasks(request, q0, margin)):
            if self._refuse(task) or (task.lower > task.upper).any():
                continue
            asked = task if task.preferences else task._replace(preferences=nearest)
            begin = self._near_starts(task, q0, starts, rng)
            for found in search_all(asked, begin, self.iterations):
                ends.append((found.cost, self._result(task, found, target=i)))
        ends.sort(key=lambda end: end[0])
        kept: list[IKResult] = []
        for _, result in ends:
            if all(np.abs(result.q - other.q).max() > distinct for other in kept):
                kept.append(result)
        return kept

    def nearest(
        self, targets: pin.SE3 | Sequence[pin.SE3], q0: np.ndarray, *, margin: float = 0.0
    ) -> IKResult:
        """Find the solution nearest to `q0`, among alternative poses too.

        Args:
            targets: A pose of the tool, or several that serve equally well.
            q0: Where the arm is.  # (nq,)
            margin: How far from the limits to stay where that is possible [rad].

        Raises:
            MotionError: When a pose, the start or the margin is not one, or there is no pose at
                all.
        """
        poses = check_poses(targets)
        margin = check_non_negative(margin, "margin", "rad")
        for bound in (margin, 0.0) if margin > 0.0 else (0.0,):
            found = self.solutions(poses, q0, starts=max(2, 8 // len(poses)), margin=bound)
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
        """Give the distance between configurations as a time at full speed [s].

        Raises:
            MotionError: When one is no configuration.
        """
        n = self.model.nq
        return self._time_between(check_configuration(q, n), check_configuration(q0, n))

    def _time_between(self, q: np.ndarray, q0: np.ndarray) -> float:
        weighted = (q - q0) * self._inverse_speed
        return float(np.sqrt(weighted.dot(weighted) / len(weighted)))

    # What is asked for

    def _task(
        self,
        request: Request,
        q0: np.ndarray,
        margin: float = 0.0,
        tolerance: float | None = None,
    ) -> Task:
        if isinstance(request, IKProblem):
            if margin:
                raise invalid(
                    f"a problem has its own margin: ask for IKProblem(margin={margin!r}) "
                    f"instead of margin={margin!r} beside it"
                )
            if tolerance is not None:
                raise invalid(
                    "each target of a problem has its own tolerance: ask for "
                    f"PoseTarget(..., tolerance={tolerance!r}) instead of tolerance={tolerance!r}"
                )
            return make_task(self.model, self._joints, request, q0, self._inverse_speed)
        tolerances = self._tolerances if tolerance is None else (tolerance, tolerance)
        if isinstance(request, Target):
            raise invalid(
                f"the {request.label} must be in a problem: ask for "
                f"IKProblem(targets={type(request).__name__}(...))"
            )
        T_wt = check_pose(request)
        self._tool_rows.aim(T_wt, tolerances)
        self._tool_system.q = None
        limits = self.model.limits
        lower, upper = limits.lower, limits.upper
        if margin:
            lower, upper = lower + margin, upper - margin
        frames, rows = (self.tool,), ((self._tool_rows,),)
        return Task(self._tool_system, lower, upper, self._joints, frames, rows, None, request)

    def _tasks(
        self, request: Request | Sequence[pin.SE3], q0: np.ndarray, margin: float
    ) -> Iterator[Task]:
        single = isinstance(request, IKProblem | Target)
        for one in [request] if single else check_poses(request):
            yield self._task(one, q0, margin)

    def _refuse(self, task: Task) -> str:
        return "" if task.tool_pose is None else self._reach.refuse(task.tool_pose)

    # Where searches start

    def _start(self, q: np.ndarray) -> np.ndarray:
        q = check_configuration(q, self.model.nq)
        return np.minimum(np.maximum(q, self.model.limits.lower), self.model.limits.upper)

    def _starts(
        self, task: Task, q0: np.ndarray, restarts: int, rng: np.random.Generator | None
    ) -> Iterator[np.ndarray]:
        """Give the first start, and then those near to meeting the task, far from each other."""
        yield q0
        if restarts > 0:
            yield from self._further.spread(task, restarts, rng)

    def _near_starts(
        self, task: Task, q0: np.ndarray, count: int, rng: np.random.Generator | None
    ) -> Iterator[np.ndarray]:
        """Give the first start, and then of those nearest to meeting the task the nearest."""
        yield np.minimum(np.maximum(q0, task.lower), task.upper)
        if not count:
            return
        starts = self._further.nearest(task, 8 * count, rng)
        far = [self._time_between(q, q0) for q in starts]
        yield from starts[np.argsort(far, kind="stable")[:count]]

    def _result(self, task: Task, found: Found, target: int = 0) -> IKResult:
        return IKResult(
            found.q,
            found.solved,
            task.residuals(found.q),
            found.iterations,
            found.restarts,
            found.reason,
            target,
            found.cost if task.preferences else 0.0,
        )
