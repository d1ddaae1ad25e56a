"""Inverse kinematics: configurations for poses of the tool."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from ..checks import check_configuration, check_pose, check_poses
from .descent import Descended, Descent
from .reach import Reach
from .result import IKResult
from .self_motion import PULLS, SelfMotion

STORED = 2000  # configurations to restart from
PATIENCE = 15  # steps without progress, where there is no restart


class InverseKinematics:
    """Find joint configurations for tool poses, inside the limits, by bounded searches.

    Levenberg-Marquardt from the start that is asked for; where it ends beside the target, again
    from the stored configurations whose poses are nearest to it. The stored ones are drawn once
    from a seeded generator and nothing is drawn afterwards: the same request gives the same
    answer.
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
            position_tolerance: Of a solution [m].
            rotation_tolerance: Of a solution [rad].
        """
        self.model = model.copy()
        self.restarts = restarts
        self.position_tolerance = position_tolerance
        self.rotation_tolerance = rotation_tolerance
        self.self_motion = SelfMotion(self.model)
        self._descent = Descent(self.model, iterations=iterations)
        limits = model.limits
        self._inverse_speed = 1.0 / limits.velocity
        rng = np.random.default_rng(seed)
        lower, upper = np.maximum(limits.lower, -np.pi), np.minimum(limits.upper, np.pi)
        self._stored = rng.uniform(lower, upper, (max(STORED, restarts), model.nq))
        self._reach = Reach(self.model, self._stored)
        poses = [self.model.pose(q) for q in self._stored]
        self._stored_position = np.array([T.translation for T in poses])
        self._stored_quat = np.array([pin.Quaternion(T.rotation).coeffs() for T in poses])

    def solve(self, T_wt: pin.SE3, q0: np.ndarray, *, restarts: int | None = None) -> IKResult:
        """Find a configuration for a pose, the first from `q0` downhill.

        Args:
            T_wt: Pose of the tool in the world.
            q0: Where to start; it is brought inside the limits.  # (nq,)
            restarts: Starts after the first, at the most; by default as constructed.

        Raises:
            MotionError: When the pose or the start is not one.
        """
        q0 = self._start(q0)
        check_pose(T_wt)
        refused = self._reach.refuse(T_wt)
        if refused:
            return self._result(self._measure(T_wt, q0), reason=refused)
        restarts = self.restarts if restarts is None else restarts
        best = self._descend(T_wt, q0)
        iterations, count = best.iterations, 0
        if not best.solved and restarts > 0:
            for start in self._nearest_stored(T_wt, restarts):
                found = self._descend(T_wt, start)
                iterations, count = iterations + found.iterations, count + 1
                if found.solved or _error(found) < _error(best):
                    best = found
                if found.solved:
                    break
        reason = "" if best.solved else f"no solution from {count + 1} starts"
        return self._result(best, iterations=iterations, restarts=count, reason=reason)

    def follow(
        self,
        T_wt: pin.SE3,
        q0: np.ndarray,
        *,
        max_step: float = 0.2,
        margin: float = 0.0,
        tolerance: float | None = None,
        detours: bool = True,
    ) -> IKResult:
        """Find the configuration for a pose near that of `q0`, without jumping.

        Args:
            T_wt: Pose of the tool in the world.
            q0: The configuration of the pose before.  # (nq,)
            max_step: How far a joint may go from it [rad].
            margin: How far to stay from the limits, once away from them [rad].
            tolerance: Of position [m] and rotation [rad]; by default as constructed.
            detours: Whether to try again from elsewhere inside `max_step`.
        """
        limits = self.model.limits
        lower = np.minimum(limits.lower + margin, q0)
        upper = np.maximum(limits.upper - margin, q0)
        least, most = np.maximum(lower, q0 - max_step), np.minimum(upper, q0 + max_step)
        iterations = 0
        # Joints that run into a limit together can hold each other there; from the middle of where
        # they may go the way is another.
        middle = 0.5 * (least + most)
        for start in (q0, middle, 0.5 * (middle + q0)) if detours else (q0,):
            found = self._descent(
                T_wt,
                start,
                position_tolerance=self.position_tolerance if tolerance is None else tolerance,
                rotation_tolerance=self.rotation_tolerance if tolerance is None else tolerance,
                lower=least,
                upper=most,
                patience=PATIENCE,
            )
            iterations += found.iterations
            if found.solved:
                break
        reason = ""
        if not found.solved:
            at_limit = (found.q <= lower) | (found.q >= upper)
            names = [self._joint_name(int(i)) for i in np.flatnonzero(at_limit)]
            if names:
                reason = f"{' and '.join(names)} at the limit"
            elif np.abs(found.q - q0).max() >= max_step:
                reason = f"a joint would have to jump by more than {max_step:g} rad"
            else:
                reason = "out of reach, or singular"
        return self._result(found, iterations=iterations, reason=reason)

    def solutions(
        self,
        targets: pin.SE3 | Sequence[pin.SE3],
        q0: np.ndarray,
        *,
        starts: int = 8,
        margin: float = 0.0,
        distinct: float = 0.1,
    ) -> list[IKResult]:
        """List distinct solutions, the nearest to `q0` first.

        Each is moved along its self-motion to where it is nearest. The distance is the time that
        the joints would need at their greatest speeds, root mean square (`distance`).

        Args:
            targets: A pose, or several that serve equally well.
            q0: Where the arm is.  # (nq,)
            starts: How many stored configurations to start from for each pose.
            margin: How far from the limits solutions stay [rad].
            distinct: Solutions differ by more than this in some joint [rad].

        Raises:
            MotionError: When a pose or the start is not one.
        """
        q0, poses = self._start(q0), check_poses(targets)
        limits = self.model.limits
        lower, upper = limits.lower + margin, limits.upper - margin
        found: list[IKResult] = []
        for i, T in enumerate(poses):
            if self._reach.refuse(T):
                continue
            near = self._nearest_stored(T, 8 * starts)
            near = near[np.argsort([self.distance(q, q0) for q in near], kind="stable")][:starts]
            for start in (np.clip(q0, lower, upper), *near):
                end = self._descend(T, np.clip(start, lower, upper), lower=lower, upper=upper)
                if end.solved:
                    end = self._pull(T, end, q0, lower, upper)
                    found.append(self._result(end, iterations=end.iterations, target=i))
        found.sort(key=lambda result: self.distance(result.q, q0))
        kept: list[IKResult] = []
        for result in found:
            if all(np.abs(result.q - other.q).max() > distinct for other in kept):
                kept.append(result)
        return kept

    def nearest(
        self, targets: pin.SE3 | Sequence[pin.SE3], q0: np.ndarray, *, margin: float = 0.0
    ) -> IKResult:
        """Find the solution nearest to `q0`, among alternative poses too.

        Args:
            targets: A pose, or several that serve equally well.
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
        best = last[i]
        return IKResult(
            best.q,
            best.solved,
            best.position_error,
            best.rotation_error,
            sum(result.iterations for result in last),
            best.restarts,
            best.reason,
            i,
        )

    def distance(self, q: np.ndarray, q0: np.ndarray) -> float:
        """Give the distance between configurations as a time at full speed [s]."""
        weighted = (q - q0) * self._inverse_speed
        return float(np.sqrt(weighted.dot(weighted) / len(weighted)))

    def _start(self, q: np.ndarray) -> np.ndarray:
        q = check_configuration(q, self.model.nq)
        return np.minimum(np.maximum(q, self.model.limits.lower), self.model.limits.upper)

    def _joint_name(self, i: int) -> str:
        return str(self.model.model.names[i + 1])

    def _descend(
        self,
        T: pin.SE3,
        q: np.ndarray,
        lower: np.ndarray | None = None,
        upper: np.ndarray | None = None,
    ) -> Descended:
        return self._descent(
            T,
            q,
            position_tolerance=self.position_tolerance,
            rotation_tolerance=self.rotation_tolerance,
            lower=lower,
            upper=upper,
        )

    def _measure(self, T: pin.SE3, q: np.ndarray) -> Descended:
        T_td = self.model.pose(q).actInv(T)
        position = float(np.linalg.norm(T_td.translation))
        rotation = float(np.linalg.norm(pin.log3(T_td.rotation)))
        return Descended(q, position, rotation, 0, False)

    def _nearest_stored(self, T: pin.SE3, n: int) -> np.ndarray:
        """Give the stored configurations whose poses are nearest, nearest first."""  # (n, nq)
        cosine = self._stored_quat @ pin.Quaternion(T.rotation).coeffs()
        offset = self._stored_position - T.translation
        far = (offset * offset).sum(axis=1) + 1.0 - cosine * cosine
        n = min(n, len(far))
        chosen = np.argpartition(far, n - 1)[:n]
        return self._stored[chosen[np.argsort(far[chosen], kind="stable")]]

    def _pull(
        self, T: pin.SE3, start: Descended, q0: np.ndarray, lower: np.ndarray, upper: np.ndarray
    ) -> Descended:
        """Move a solution along its self-motion towards `q0`, then onto the pose again."""
        pulled = self.self_motion.towards(q0, T, start.q, lower, upper)
        if pulled is start.q:
            return start
        end = self._descend(T, pulled, lower=lower, upper=upper)
        if not end.solved or self.distance(end.q, q0) >= self.distance(start.q, q0):
            return start
        return end._replace(iterations=start.iterations + PULLS + end.iterations)

    def _result(
        self,
        found: Descended,
        *,
        iterations: int = 0,
        restarts: int = 0,
        reason: str = "",
        target: int = 0,
    ) -> IKResult:
        return IKResult(
            found.q.copy(),
            found.solved,
            found.position_error,
            found.rotation_error,
            iterations,
            restarts,
            reason,
            target,
        )


def _error(found: Descended) -> float:
    return found.position_error + found.rotation_error
