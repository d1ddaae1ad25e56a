"""The tool on a straight line: a path in joint space."""

import numpy as np
import pinocchio as pin

from bt_manip.robots import JointLimits, ToolLimits

from .bounds import Bounds
from .errors import MotionError
from .kinematics import IKProblem, IKResult, InverseKinematics, PoseTarget
from .paths import SplinePath

SPACING = 0.02  # [m] between the poses that are solved
TURN = 0.1  # [rad] between them
LEAST, MOST = 12, 400  # intervals on a line
STRAIGHTNESS = 5e-5  # [m] and [rad] that the path may leave the line between them
GRID = 500  # points where the joint limits are looked at
REFINEMENTS = 4
SUBSTEPS = 8  # where a step is too long for the solver
ARM_LENGTH = 0.3  # [m/rad] how a turn counts as travel
MARGIN = 5e-3  # [rad] from the joint limits, for what a spline swings beyond its knots
NODE_TOLERANCE = 1e-9


class ToolLine:
    """A straight line of the tool from one pose to another, turning evenly on the way."""

    def __init__(self, start: pin.SE3, end: pin.SE3) -> None:
        """Connect two poses of the tool in the world."""
        self._start, self._end = start, end
        self._turn = pin.log3(start.rotation.T @ end.rotation)
        self.length = float(np.linalg.norm(end.translation - start.translation))  # [m]
        self.angle = float(np.linalg.norm(self._turn))  # [rad]

    def pose(self, fraction: float) -> pin.SE3:
        """Give the pose T_wt at a fraction of the way."""
        along = (1.0 - fraction) * self._start.translation + fraction * self._end.translation
        return pin.SE3(self._start.rotation @ pin.exp3(fraction * self._turn), along)

    def bounds(self, joints: Bounds, tool: ToolLimits) -> Bounds:
        """Append the limits of the fraction of the way, which bound the tool's motion."""

        def least(linear: float, angular: float) -> float:
            return min(linear / max(self.length, 1e-9), angular / max(self.angle, 1e-9))

        return joints.and_also(
            least(tool.velocity, tool.angular_velocity),
            least(tool.acceleration, tool.angular_acceleration),
            least(tool.jerk, tool.angular_jerk),
        )


def line_path(ik: InverseKinematics, q0: np.ndarray, line: ToolLine) -> SplinePath:
    """Follow a line of the tool with the joints.

    The path carries the fraction of the way as a last coordinate.

    Args:
        ik: Inverse kinematics of the arm.
        q0: Where the arm is.  # (nq,)
        line: Starts at the tool pose of `q0`.

    Raises:
        MotionError: When the line leaves the reach or the limits, or a joint would have to jump;
            the message says where.
    """
    intervals = int(np.ceil(max(line.length / SPACING, line.angle / TURN)))
    intervals = int(np.clip(intervals, LEAST, MOST))
    worst = np.inf
    for _ in range(REFINEMENTS):
        path = SplinePath(_follow(ik, q0, line, intervals), ik.model.nq)
        _check_limits(path, ik.model.limits)
        between = (np.arange(intervals) + 0.5) / intervals
        worst = 0.0
        for *q, fraction in path.evaluate(between, 0)[0]:
            T_td = ik.model.pose(np.array(q)).actInv(line.pose(fraction))
            worst = max(worst, float(np.abs(pin.log6(T_td).np).max()))
        if worst <= STRAIGHTNESS:
            return path
        intervals *= 2
    raise MotionError(
        f"the line cannot be followed smoothly: it would be left by {1e3 * worst:.2f} mm",
        reason="line",
    )


def _check_limits(path: SplinePath, limits: JointLimits) -> None:
    """Refuse a path that swings beyond a limit which the arm already stands at."""
    q = path.evaluate(np.linspace(0.0, 1.0, GRID), 0)[0][:, : path.nq]
    beyond = ((q < limits.lower - 1e-9) | (q > limits.upper + 1e-9)).any(axis=0)
    if beyond.any():
        joint = int(np.flatnonzero(beyond)[0]) + 1
        raise MotionError(
            f"the line cannot be followed: joint {joint} would leave its limits", reason="line"
        )


def _follow(ik: InverseKinematics, q0: np.ndarray, line: ToolLine, intervals: int) -> np.ndarray:
    """Solve poses at even fractions of the way."""  # (intervals + 1, nq + 1)
    fractions = np.arange(intervals + 1) / intervals
    travel = max(line.length, ARM_LENGTH * line.angle) / intervals
    knots = [np.array(q0)]

    def follow(fraction: float, start: np.ndarray) -> IKResult:
        target = PoseTarget(ik.tool, line.pose(fraction), tolerance=NODE_TOLERANCE)
        return ik.follow(IKProblem(targets=[target], margin=MARGIN), start, detours=False)

    for done, fraction in zip(fractions, fractions[1:], strict=False):
        start = knots[-1] + travel * ik.self_motion.away_from_limits(knots[-1])
        start = np.clip(start, ik.model.limits.lower, ik.model.limits.upper)
        found = follow(fraction, start)
        for part in np.linspace(done, fraction, SUBSTEPS + 1)[1:] if not found.solved else ():
            found = follow(part, start)
            start = found.q
        if not found.solved:
            raise MotionError(
                f"the line can be followed for {100.0 * done:.0f} % of the way only "
                f"({done * line.length:.3f} m of {line.length:.3f} m): {found.reason}",
                reason="line",
            )
        knots.append(found.q)
    return np.column_stack([knots, fractions])
