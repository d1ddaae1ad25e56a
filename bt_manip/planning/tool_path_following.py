"""Joint paths that follow a path of the tool."""

from itertools import pairwise

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError
from bt_manip.kinematics import IKResult, InverseKinematics, null_space_step
from bt_manip.robots import MotionLimits
from bt_manip.trajectories import SplinePath

from .tool_path import ToolPath

SPACING = 0.02  # [m] between the knots, before refinement
TURN = 0.1  # [rad] between the knots, before refinement
KNOTS_PER_CORNER = 6  # in the narrowest corner
MIN_INTERVALS, MAX_FIRST_INTERVALS = 8, 400  # before refinement
MAX_REFINED_INTERVALS = 1600
REFINEMENTS = 6  # attempts, each with twice the knots: at sharp turns of a joint the last is needed
QUICK_REFINEMENTS = 4  # attempts for lines that shall be easy to follow
KNOT_TOLERANCE = 1e-8  # [m] and [rad] deviation of the tool at the knots that is aimed at
PATH_TOLERANCE = 5e-5  # [m] and [rad] by which it may be larger between the knots
LIMIT_SAMPLES = 500  # configurations whose joint limits are checked
LIMIT_MARGIN = 5e-3  # [rad] of the knots from the joint limits, for the overshoot of the spline
MAX_STEP = 0.2  # [rad] displacement of a joint between two knots
SUBSTEPS = 8  # where inverse kinematics fails from one knot to the next


def follow_tool_path(
    ik: InverseKinematics, q0: np.ndarray, path: ToolPath, refinements: int = REFINEMENTS
) -> SplinePath:
    """Return the joint path that follows a path of the tool.

    Args:
        ik: Inverse kinematics of the arm.
        q0: Configuration at the start of the path [rad].  # (nq,)
        path: The tool path, which starts at the tool pose of `q0`.
        refinements: Number of attempts, each with twice as many knots.

    Returns:
        A spline of the joints and of `ToolPath.extra_columns`.

    Raises:
        MotionError: When the path leaves the workspace or the joint limits, or a joint would have
            to jump; the message says where.
    """
    intervals = max(path.length / SPACING, path.angle / TURN, KNOTS_PER_CORNER / path.narrowest)
    intervals = int(np.clip(np.ceil(intervals), MIN_INTERVALS, MAX_FIRST_INTERVALS))
    for _ in range(refinements):
        knots, deviation = _solve_knots(ik, q0, path, intervals)
        curve = SplinePath(knots, ik.model.nq, path.limits(ik.model.limits.tool))
        error = limit_error(curve, ik.model.limits) or _deviation_error(
            curve, ik, path, intervals, deviation + PATH_TOLERANCE
        )
        if not error:
            return curve
        intervals *= 2
        if intervals > MAX_REFINED_INTERVALS:
            break
    raise MotionError(f"the {path.name} cannot be followed{error}", reason="line")


def limit_error(curve: SplinePath, limits: MotionLimits) -> str:
    """Say which joint limit the spline exceeds between its knots; empty where it does not."""
    q = curve.evaluate(np.linspace(0.0, 1.0, LIMIT_SAMPLES), 0)[0][:, : curve.nq]
    outside = ((q < limits.lower - 1e-9) | (q > limits.upper + 1e-9)).any(axis=0)
    if not outside.any():
        return ""
    return f": joint {int(np.flatnonzero(outside)[0]) + 1} would leave its limits"


def _deviation_error(
    curve: SplinePath, ik: InverseKinematics, path: ToolPath, intervals: int, tolerance: float
) -> str:
    """Say how far the tool deviates between the knots; empty where that is within tolerance."""
    worst = 0.0
    for row in curve.evaluate((np.arange(intervals) + 0.5) / intervals, 0)[0]:
        T_td = ik.model.pose(row[: curve.nq]).actInv(path.pose(row[-1]))
        worst = max(worst, *map(abs, pin.log6(T_td).np.tolist()))
    if worst <= tolerance:
        return ""
    return f" smoothly: the tool would deviate by {1e3 * worst:.2f} mm"


def _solve_knots(
    ik: InverseKinematics, q0: np.ndarray, path: ToolPath, intervals: int
) -> tuple[np.ndarray, float]:
    """Solve inverse kinematics at even fractions of the path.

    Returns:
        The rows of the spline, and the largest deviation of the tool there [m] or [rad].
    """  # (intervals + 1, m)
    fractions = (np.arange(intervals + 1) / intervals).tolist()
    travel = path.travel / intervals
    lower, upper = ik.model.limits.lower + LIMIT_MARGIN, ik.model.limits.upper - LIMIT_MARGIN
    knots, steps, deviation = [np.array(q0)], [np.zeros(len(q0))], 0.0
    for done, fraction in pairwise(fractions):
        q = knots[-1]
        # Extrapolate linearly from the last two steps.
        likely = 2.0 * steps[-1] - steps[-2] if len(steps) > 2 else steps[-1]
        guess = q + null_space_step(ik.model, q, likely, travel)
        guess = np.minimum(np.maximum(guess, np.minimum(lower, q)), np.maximum(upper, q))
        found = _solve(ik, path.pose(fraction), guess)
        if not found.solved or np.abs(found.q - q).max() > MAX_STEP:
            found = _solve_in_substeps(ik, path, (done, fraction), q)
        if not found.solved:
            share, progress = path.progress(done)
            raise MotionError(
                f"the {path.name} can be followed only for {progress}: {found.reason}",
                reason="line",
                fraction=share,
            )
        knots.append(found.q)
        steps.append(found.q - q)
        deviation = max(deviation, found.position_error, found.rotation_error)
    return np.column_stack([knots, path.extra_columns(np.array(fractions))]), deviation


def _solve_in_substeps(
    ik: InverseKinematics, path: ToolPath, fractions: tuple[float, float], q: np.ndarray
) -> IKResult:
    """Solve inverse kinematics from one fraction of the path to another in short steps."""
    for fraction in np.linspace(*fractions, SUBSTEPS + 1)[1:].tolist():
        found = _solve(ik, path.pose(fraction), q)
        q = found.q
    return found


def _solve(ik: InverseKinematics, T_wt: pin.SE3, guess: np.ndarray) -> IKResult:
    return ik.follow(
        T_wt,
        guess,
        max_step=MAX_STEP,
        retry=False,
        margin=LIMIT_MARGIN,
        tolerance=KNOT_TOLERANCE,
    )
