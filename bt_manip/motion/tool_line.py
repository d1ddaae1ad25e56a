"""The tool on a straight line: a path in joint space."""

import numpy as np
import pinocchio as pin

from .errors import MotionError
from .inverse_kinematics import InverseKinematics
from .paths import SplinePath
from .timing import ToolLine

SPACING = 0.02  # [m] between the poses that are solved
TURN = 0.1  # [rad] between them
LEAST, MOST = 12, 400  # poses on a line
STRAIGHTNESS = 1e-5  # [m] and [rad] that the spline may leave the line between them
REFINEMENTS = 3
NODE_TOLERANCE = 1e-9


def line_path(ik: InverseKinematics, q0: np.ndarray, T_wt: pin.SE3) -> tuple[SplinePath, ToolLine]:
    """Follow the straight line from where the tool is to a pose, turning evenly on the way.

    Args:
        ik: Inverse kinematics of the arm.
        q0: Where the arm is.  # (nq,)
        T_wt: Pose of the tool at the end.

    Raises:
        MotionError: When the line leaves the reach or the limits, or a joint would have to jump;
            the message says where.
    """
    start = ik.model.pose(q0)
    length = float(np.linalg.norm(T_wt.translation - start.translation))
    turn = pin.log3(start.rotation.T @ T_wt.rotation)
    line = ToolLine(length, float(np.linalg.norm(turn)))

    def pose_at(s: float) -> pin.SE3:
        along = (1.0 - s) * start.translation + s * T_wt.translation
        return pin.SE3(start.rotation @ pin.exp3(s * turn), along)

    intervals = int(np.ceil(max(length / SPACING, line.angle / TURN)))
    intervals = int(np.clip(intervals, LEAST, MOST))
    worst = np.inf
    for _ in range(REFINEMENTS):
        path = SplinePath(_follow(ik, q0, pose_at, intervals, line))
        between = (np.arange(intervals) + 0.5) / intervals
        worst = 0.0
        for s, q in zip(between, path.evaluate(between, 0)[0], strict=True):
            worst = max(
                worst, float(np.abs(pin.log6(ik.model.pose(q).actInv(pose_at(s))).np).max())
            )
        if worst <= STRAIGHTNESS:
            return path, line
        intervals *= 2
    raise MotionError(
        f"the line cannot be followed smoothly: it would be left by {1e3 * worst:.2f} mm",
        reason="line",
    )


def _follow(
    ik: InverseKinematics, q0: np.ndarray, pose_at: object, intervals: int, line: ToolLine
) -> np.ndarray:
    assert callable(pose_at)
    knots = [np.array(q0)]
    for i in range(1, intervals + 1):
        s = i / intervals
        found = ik.follow(pose_at(s), knots[-1], tolerance=NODE_TOLERANCE)
        if not found.solved:
            where = f"{100.0 * (i - 1) / intervals:.0f} % of it"
            if line.length > 1e-6:
                where += f" ({line.length * (i - 1) / intervals:.3f} m of {line.length:.3f} m)"
            raise MotionError(
                f"the line can be followed for {where} only: {found.reason}", reason="line"
            )
        knots.append(found.q)
    return np.array(knots)
