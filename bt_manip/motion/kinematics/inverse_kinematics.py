"""Inverse kinematics: configurations for poses of the tool, and for problems one states."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from ..checks import check_configuration, check_pose, check_poses
from .descent import STALL_STEPS, Descended, descend
from .improvement import Improved, improve
from .preferences import Posture, Preferences
from .problem import IKProblem
from .reach import Reach
from .result import IKResult
from .rows import PoseRows
from .self_motion import SelfMotion
from .starts import StoredStarts, drawn_starts
from .system import System
from .task import Task, make_task

STORED = 2000  # configurations to restart from
PATIENCE = 15  # steps without progress, where there is no restart
TRIES = 8  # starts of a problem that has costs alone, of which the best end is taken

Request: TypeAlias = pin.SE3 | IKProblem
"""A pose T_wt of the tool in the world, or a problem."""


class InverseKinematics:
    """Find joint configurations inside the limits, by bounded searches.

    A request is a pose of the tool, or an `IKProblem`. Levenberg-Marquardt goes from the start
    that is asked for; where it ends beside the targets, again from the configurations that are
    nearest to meeting them. For poses of the tool these were drawn once from a seeded generator,
    for other problems they are drawn from the generator that is handed in: the same request gives
    the same answer. A solution is moved along what its constraints leave free to where the
    problem's costs are least.

    Attributes:
        model: The arm.
        tool: Name of the frame that a pose alone is about.
    """

    def __init__(
        self,
        model: RobotModel,
        *,
        restarts: int = 60,
        iterations: int = 50,
        seed: int = 0,
        position_tolerance: float = 1e-6,
        rotation_tolerance: float = 1e-6,
    ) -> None:
        """Prepare for an arm.

        Args:
            model: The arm; a copy is kept.
            restarts: Starts after the first, at the most.
            iterations: Steps from each start, at the most.
            seed: Of the stored configurations.
            position_tolerance: Of a solution for a pose [m].
            rotation_tolerance: Of a solution for a pose [rad].
        """
        self.model = model.copy()
        self.restarts, self.iterations = restarts, iterations
        self.self_motion = SelfMotion(self.model)
        self._inverse_speed = 1.0 / model.limits.velocity
        self._stored = StoredStarts(self.model, max(STORED, restarts), np.random.default_rng(seed))
        self._reach = Reach(self.model, self._stored.q)
        tool = self.model.tool_frame_id
        tolerances = position_tolerance, rotation_tolerance
        self.tool = str(self.model.model.frames[tool].name)
        self._tool_rows = PoseRows(self.model, tool, self.model.pose(self.model.home), tolerances)
        self._tool_system = System(self.model, [self._tool_rows])

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
            restarts: Starts after the first, at the most; by default as constructed.
            rng: What further starts of a problem are drawn from; by default a new generator, so
                that the same request gives the same answer.

        Returns:
            The solution, or what came nearest. Of a problem without constraints, the least cost
            of several starts.

        Raises:
            MotionError: When the request or the start is none.
        """
        q0 = self._start(q0)
        task = self._task(request, q0)
        start = np.minimum(np.maximum(q0, task.lower), task.upper)
        refused = self._refuse(task)
        if refused:
            return self._result(task, start, False, reason=refused)
        restarts = self.restarts if restarts is None else restarts
        wanted = 1 if task.system.rows else TRIES
        found: list[Improved] = []
        best: Descended | None = None
        blocked = ""
        iterations, count = 0, -1
        for begin in self._starts(task, start, restarts, rng):
            count += 1
            end = self._descend(task, begin)
            iterations += end.iterations
            obstacle = task.blocked(end.q) if end.solved else ""
            if end.solved and not obstacle:
                found.append(self._improve(task, end))
                iterations += found[-1].iterations
                if len(found) == wanted:
                    break
            elif best is None or (not end.solved, end.error) < (not best.solved, best.error):
                best, blocked = end, obstacle
        if found:
            least = min(found, key=lambda improved: improved.cost)
            return self._result(task, least.q, True, iterations=iterations, restarts=count)
        assert best is not None
        reason = f"no solution from {count + 1} starts"
        if best.solved:
            reason = f"no free solution from {count + 1} starts: {blocked}"
        return self._result(
            task, best.q, False, iterations=iterations, restarts=count, reason=reason
        )

    def follow(
        self,
        request: Request,
        q0: np.ndarray,
        *,
        max_step: float = 0.2,
        detours: bool = True,
    ) -> IKResult:
        """Find the configuration near `q0`, without jumping and without restarts.

        Args:
            request: A pose of the tool, or a problem; its margin is kept once `q0` keeps it.
            q0: The configuration before.  # (nq,)
            max_step: How far a joint may go from it [rad].
            detours: Whether to try again from elsewhere inside `max_step`.

        Raises:
            MotionError: When the problem is none.
        """
        task = self._task(request, q0)
        lower, upper = np.minimum(task.lower, q0), np.maximum(task.upper, q0)
        least, most = np.maximum(lower, q0 - max_step), np.minimum(upper, q0 + max_step)
        near = task._replace(lower=least, upper=most)
        iterations = 0
        # Joints that run into a limit together can hold each other there; from the middle of where
        # they may go the way is another.
        middle = 0.5 * (least + most)
        for start in (q0, middle, 0.5 * (middle + q0)) if detours else (q0,):
            end = self._descend(near, start, patience=PATIENCE)
            iterations += end.iterations
            if end.solved:
                break
        if not end.solved:
            reason = self._why_not(end.q, q0, lower, upper, max_step)
            return self._result(near, end.q, False, iterations=iterations, reason=reason)
        improved = self._improve(near, end)
        blocked = near.blocked(improved.q)
        return self._result(
            near,
            improved.q,
            not blocked,
            iterations=iterations + improved.iterations,
            reason=blocked,
        )

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
            margin: How far from the limits solutions for poses stay [rad].
            distinct: Solutions differ by more than this in some joint [rad].
            rng: As for `solve`.

        Raises:
            MotionError: When the request or the start is none.
        """
        q0 = self._start(q0)
        found: list[tuple[float, IKResult]] = []
        nearest = Preferences(self._inverse_speed, posture=Posture(q0, 1.0))
        for i, task in enumerate(self._tasks(request, q0, margin)):
            if self._refuse(task):
                continue
            asked = task if task.preferences else task._replace(preferences=nearest)
            for begin in self._near_starts(task, q0, starts, rng):
                end = self._descend(task, begin)
                if not end.solved:
                    continue
                better = self._improve(asked, end)
                if task.blocked(better.q):
                    continue
                steps = end.iterations + better.iterations
                result = self._result(task, better.q, True, iterations=steps, target=i)
                found.append((better.cost, result))
        found.sort(key=lambda pair: pair[0])
        kept: list[IKResult] = []
        for _, result in found:
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
            MotionError: When a pose or the start is not one, or there is no pose at all.
        """
        poses = check_poses(targets)
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
        return replace(last[i], iterations=iterations, target=i)

    def distance(self, q: np.ndarray, q0: np.ndarray) -> float:
        """Give the distance between configurations as a time at full speed [s]."""
        weighted = (q - q0) * self._inverse_speed
        return float(np.sqrt(weighted.dot(weighted) / len(weighted)))

    # What is asked for

    def _task(self, request: Request, q0: np.ndarray, margin: float = 0.0) -> Task:
        if isinstance(request, IKProblem):
            return make_task(self.model, request, q0, self._inverse_speed)
        self._tool_rows.pose, self._tool_system.q = check_pose(request), None
        limits = self.model.limits
        lower, upper = limits.lower, limits.upper
        if margin:
            lower, upper = lower + margin, upper - margin
        frames, rows = (self.tool,), ((self._tool_rows,),)
        return Task(self._tool_system, lower, upper, frames, rows, None, request)

    def _tasks(
        self, request: Request | Sequence[pin.SE3], q0: np.ndarray, margin: float
    ) -> Iterator[Task]:
        if isinstance(request, IKProblem):
            yield self._task(request, q0)
            return
        for T_wt in check_poses(request):
            yield self._task(T_wt, q0, margin)

    def _refuse(self, task: Task) -> str:
        return "" if task.tool_pose is None else self._reach.refuse(task.tool_pose)

    # Where searches start

    def _start(self, q: np.ndarray) -> np.ndarray:
        q = check_configuration(q, self.model.nq)
        return np.minimum(np.maximum(q, self.model.limits.lower), self.model.limits.upper)

    def _starts(
        self, task: Task, q0: np.ndarray, restarts: int, rng: np.random.Generator | None
    ) -> Iterator[np.ndarray]:
        """Give the first start, and then those nearest to meeting the task."""
        yield q0
        if restarts > 0:
            yield from self._further(task, restarts, rng)

    def _further(
        self, task: Task, count: int, rng: np.random.Generator | None
    ) -> np.ndarray:  # (n, nq)
        if task.tool_pose is not None:
            return np.clip(self._stored.nearest(task.tool_pose, count), task.lower, task.upper)
        return drawn_starts(task, count, np.random.default_rng(0) if rng is None else rng)

    def _near_starts(
        self, task: Task, q0: np.ndarray, count: int, rng: np.random.Generator | None
    ) -> Iterator[np.ndarray]:
        """Give the first start, and then of those nearest to meeting the task the nearest."""
        yield np.clip(q0, task.lower, task.upper)
        starts = self._further(task, 8 * count, rng)
        far = [self.distance(q, q0) for q in starts]
        yield from starts[np.argsort(far, kind="stable")[:count]]

    # How it is searched

    def _descend(self, task: Task, q: np.ndarray, patience: int = STALL_STEPS) -> Descended:
        return descend(
            task.system, q, task.lower, task.upper, iterations=self.iterations, patience=patience
        )

    def _improve(self, task: Task, end: Descended) -> Improved:
        """Move a solution to where it costs least, unless it would touch something there."""
        if task.preferences is None:
            return Improved(end.q, 0.0, 0)
        better = improve(task.system, task.preferences, end.q, task.lower, task.upper)
        if task.blocked(better.q):
            return Improved(end.q, task.cost(end.q), better.iterations)
        return better

    def _why_not(
        self,
        q: np.ndarray,
        q0: np.ndarray,
        lower: np.ndarray,
        upper: np.ndarray,
        max_step: float,
    ) -> str:
        at_limit = ((q <= lower) | (q >= upper)) & (lower < upper)
        names = [str(self.model.model.names[i + 1]) for i in np.flatnonzero(at_limit).tolist()]
        if names:
            return f"{' and '.join(names)} at the limit"
        if np.abs(q - q0).max() >= max_step:
            return f"a joint would have to jump by more than {max_step:g} rad"
        return "out of reach, or singular"

    def _result(
        self,
        task: Task,
        q: np.ndarray,
        solved: bool,
        *,
        iterations: int = 0,
        restarts: int = 0,
        reason: str = "",
        target: int = 0,
    ) -> IKResult:
        residuals = task.residuals(q)
        cost = task.cost(q)
        return IKResult(q.copy(), solved, residuals, iterations, restarts, reason, target, cost)
