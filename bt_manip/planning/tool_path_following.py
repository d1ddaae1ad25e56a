"""Joints that follow a path of the tool."""

from itertools import pairwise

import numpy as np
import pinocchio as pin

from bt_manip.exceptions import MotionError
from bt_manip.kinematics import IKResult, InverseKinematics
from bt_manip.robots import JointLimits
from bt_manip.trajectories import SplinePath

from .tool_path import ToolPath

SPACING = 0.02  # [m] between the poses that are solved
TURN = 0.1  # [rad] between them
CORNER = 6  # intervals in the narrowest corner, at the least
LEAST, MOST = 8, 400  # intervals on a path
STRAIGHTNESS = 5e-5  # [m] and [rad] that the joints may leave the path between them
GRID = 500  # points where the joint limits are looked at
REFINEMENTS = 6  # where a joint turns sharply, the spline follows in the last of them
SMOOTH = 4  # of them, that a line takes which is easy to drive
FINEST = 1600  # intervals
SUBSTEPS = 8  # where a step is too long for the solver
MARGIN = 5e-3  # [rad] from the joint limits, for what a spline swings beyond its knots
NODE_TOLERANCE = 1e-8  # [m] and [rad]
MAX_STEP = 0.2  # [rad] that a joint may go by between two poses


def follow_path(
    ik: InverseKinematics, q0: np.ndarray, path: ToolPath, refinements: int = REFINEMENTS
) -> SplinePath:
    """Follow a path of the tool with the joints.

    Args:
        ik: Inverse kinematics of the arm.
        q0: Where the arm is.  # (nq,)
        path: InitialGuesses at the tool pose of `q0`.
        refinements: How often it is tried, each time with twice as many poses.

    Returns:
        A path that carries what `ToolPath.carried` gives, the fraction of the way last.

    Raises:
        MotionError: When the path leaves the reach or the limits, or a joint would have to jump;
            the message says where.
    """
    nq = ik.model.nq
    intervals = max(path.length / SPACING, path.angle / TURN, CORNER / path.finest)
    intervals = int(np.clip(np.ceil(intervals), LEAST, MOST))
    for _ in range(refinements):
        curve = SplinePath(_follow(ik, q0, path, intervals), nq)
        fault = _beyond(curve, ik.model.limits) or _left(curve, ik, path, intervals)
        if not fault:
            return curve
        intervals *= 2
        if intervals > FINEST:
            break
    raise MotionError(f"the {path.name} cannot be followed{fault}", reason="line")


def _beyond(curve: SplinePath, limits: JointLimits) -> str:
    """Say where a spline swings beyond a limit that a joint is led along; empty where it does not.

    The nearer its knots are, the less it swings.
    """
    q = curve.evaluate(np.linspace(0.0, 1.0, GRID), 0)[0][:, : curve.nq]
    beyond = ((q < limits.lower - 1e-9) | (q > limits.upper + 1e-9)).any(axis=0)
    if not beyond.any():
        return ""
    return f": joint {int(np.flatnonzero(beyond)[0]) + 1} would leave its limits"


def _left(curve: SplinePath, ik: InverseKinematics, path: ToolPath, intervals: int) -> str:
    """Say how far the tool leaves a path between the knots; empty where that is next to nothing."""
    worst = 0.0
    for row in curve.evaluate((np.arange(intervals) + 0.5) / intervals, 0)[0]:
        T_td = ik.model.pose(row[: curve.nq]).actInv(path.pose(row[-1]))
        worst = max(worst, *map(abs, pin.log6(T_td).np.tolist()))
    if worst <= STRAIGHTNESS:
        return ""
    return f" smoothly: it would be left by {1e3 * worst:.2f} mm"


def _follow(ik: InverseKinematics, q0: np.ndarray, path: ToolPath, intervals: int) -> np.ndarray:
    """Solve poses at even fractions of the way."""  # (intervals + 1, m)
    fractions = (np.arange(intervals + 1) / intervals).tolist()
    way = path.travel / intervals
    lower, upper = ik.model.limits.lower + MARGIN, ik.model.limits.upper - MARGIN
    knots, steps = [np.array(q0)], [np.zeros(len(q0))]
    for done, fraction in pairwise(fractions):
        q = knots[-1]
        # The next step is much like the last, and differs from it as that from the one before.
        likely = 2.0 * steps[-1] - steps[-2] if len(steps) > 2 else steps[-1]
        start = q + ik.self_motion.onwards(q, likely, way)
        start = np.minimum(np.maximum(start, np.minimum(lower, q)), np.maximum(upper, q))
        found = _solve(ik, path.pose(fraction), start)
        if not found.solved or np.abs(found.q - q).max() > MAX_STEP:
            found = _in_parts(ik, path, (done, fraction), q)
        if not found.solved:
            share, percent, metres = path.progress(done)
            raise MotionError(
                f"the {path.name} can be followed for {percent} only ({metres}): {found.reason}",
                reason="line",
                fraction=share,
            )
        knots.append(found.q)
        steps.append(found.q - q)
    return np.column_stack([knots, path.carried(np.array(fractions))])


def _in_parts(
    ik: InverseKinematics, path: ToolPath, ends: tuple[float, float], q: np.ndarray
) -> IKResult:
    """Go from one fraction of the way to another in short steps."""
    for part in np.linspace(*ends, SUBSTEPS + 1)[1:].tolist():
        found = _solve(ik, path.pose(part), q)
        q = found.q
    return found


def _solve(ik: InverseKinematics, T_wt: pin.SE3, start: np.ndarray) -> IKResult:
    return ik.follow(
        T_wt, start, max_step=MAX_STEP, detours=False, margin=MARGIN, tolerance=NODE_TOLERANCE
    )
