"""Joints that follow a path of the tool."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import JointLimits

from ..errors import MotionError
from ..kinematics import IKProblem, IKResult, InverseKinematics, PoseTarget
from ..paths import SplinePath
from .tool_path import ToolPath

SPACING = 0.02  # [m] between the poses that are solved
TURN = 0.1  # [rad] between them
CORNER = 6  # intervals in the narrowest corner, at the least
LEAST, MOST = 12, 400  # intervals on a path
STRAIGHTNESS = 5e-5  # [m] and [rad] that the joints may leave the path between them
GRID = 500  # points where the joint limits are looked at
REFINEMENTS = 4
FINEST = 1600  # intervals
SUBSTEPS = 8  # where a step is too long for the solver
MARGIN = 5e-3  # [rad] from the joint limits, for what a spline swings beyond its knots
NODE_TOLERANCE = 1e-9


def follow_path(ik: InverseKinematics, q0: np.ndarray, path: ToolPath) -> SplinePath:
    """Follow a path of the tool with the joints.

    Args:
        ik: Inverse kinematics of the arm.
        q0: Where the arm is.  # (nq,)
        path: Starts at the tool pose of `q0`.

    Returns:
        A path that carries what `ToolPath.carried` gives, the fraction of the way last.

    Raises:
        MotionError: When the path leaves the reach or the limits, or a joint would have to jump;
            the message says where.
    """
    nq = ik.model.nq
    intervals = max(path.length / SPACING, path.angle / TURN, CORNER / path.finest)
    intervals = int(np.clip(np.ceil(intervals), LEAST, MOST))
    worst = np.inf
    for _ in range(REFINEMENTS):
        curve = SplinePath(_follow(ik, q0, path, intervals), nq)
        _check_limits(curve, ik.model.limits, path)
        between = (np.arange(intervals) + 0.5) / intervals
        worst = 0.0
        for row in curve.evaluate(between, 0)[0]:
            T_td = ik.model.pose(row[:nq]).actInv(path.pose(row[-1]))
            worst = max(worst, float(np.abs(pin.log6(T_td).np).max()))
        if worst <= STRAIGHTNESS:
            return curve
        intervals *= 2
        if intervals > FINEST:
            break
    raise MotionError(
        f"the {path.name} cannot be followed smoothly: it would be left by {1e3 * worst:.2f} mm",
        reason="line",
    )


def _check_limits(curve: SplinePath, limits: JointLimits, path: ToolPath) -> None:
    """Refuse a path that swings beyond a limit which the arm already stands at."""
    q = curve.evaluate(np.linspace(0.0, 1.0, GRID), 0)[0][:, : curve.nq]
    beyond = ((q < limits.lower - 1e-9) | (q > limits.upper + 1e-9)).any(axis=0)
    if beyond.any():
        joint = int(np.flatnonzero(beyond)[0]) + 1
        raise MotionError(
            f"the {path.name} cannot be followed: joint {joint} would leave its limits",
            reason="line",
        )


def _follow(ik: InverseKinematics, q0: np.ndarray, path: ToolPath, intervals: int) -> np.ndarray:
    """Solve poses at even fractions of the way."""  # (intervals + 1, m)
    fractions = np.arange(intervals + 1) / intervals
    travel = path.travel / intervals
    knots = [np.array(q0)]

    def follow(fraction: float, start: np.ndarray) -> IKResult:
        target = PoseTarget(ik.tool, path.pose(fraction), tolerance=NODE_TOLERANCE)
        return ik.follow(IKProblem(targets=[target], margin=MARGIN), start, detours=False)

    for done, fraction in zip(fractions, fractions[1:], strict=False):
        start = knots[-1] + travel * ik.self_motion.away_from_limits(knots[-1])
        start = np.clip(start, ik.model.limits.lower, ik.model.limits.upper)
        found = follow(fraction, start)
        for part in np.linspace(done, fraction, SUBSTEPS + 1)[1:] if not found.solved else ():
            found = follow(part, start)
            start = found.q
        if not found.solved:
            share, percent, metres = path.progress(float(done))
            raise MotionError(
                f"the {path.name} can be followed for {percent} only ({metres}): {found.reason}",
                reason="line",
                fraction=share,
            )
        knots.append(found.q)
    return np.column_stack([knots, path.carried(fractions)])
