"""Which of the configurations for a pose the arm goes to."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from .errors import MotionError
from .ik_result import IKResult
from .inverse_kinematics import InverseKinematics
from .tool_line import ToolLine, line_path

_STARTS = (1, 8)  # few first: mostly the nearest serves


def choose_configuration(
    ik: InverseKinematics,
    targets: pin.SE3 | Sequence[pin.SE3],
    q0: np.ndarray,
    *,
    margin: float,
    approach: float = 0.0,
) -> IKResult:
    """Choose the configuration nearest to where the arm is.

    Args:
        ik: Inverse kinematics of the arm.
        targets: Pose of the tool in the world, or several that serve equally well.
        q0: Where the arm is.  # (nq,)
        margin: How far from the joint limits to stay where that is possible [rad].
        approach: How far the tool shall be able to go on from there, straight along its z axis,
            keeping that margin [m]. Where no configuration allows all of that, the one with the
            widest margin is taken, or else the nearest.

    Raises:
        MotionError: When a pose is none.
    """
    best: tuple[float, IKResult] | None = None
    for starts in _STARTS if approach else ():
        for found in ik.solutions(targets, q0, starts=starts, margin=margin):
            left = _margin_left(ik, found.q, approach)
            if left >= margin:
                return found
            if left > 0.0 and (best is None or left > best[0]):
                best = (left, found)
    return ik.nearest(targets, q0, margin=margin) if best is None else best[1]


def _margin_left(ik: InverseKinematics, q: np.ndarray, approach: float) -> float:
    """Give how far the joints stay from their limits on the way on, negative when there is none."""
    T = ik.model.pose(q)
    line = ToolLine(T, T * pin.SE3(np.eye(3), np.array([0.0, 0.0, approach])))
    try:
        on_the_way = line_path(ik, q, line).knots[:, : ik.model.nq]
    except MotionError:
        return -1.0
    limits = ik.model.limits
    return float(min((on_the_way - limits.lower).min(), (limits.upper - on_the_way).min()))
