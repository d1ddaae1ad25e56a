"""Which of the configurations for a pose the arm goes to."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from .collision import CollisionWorld
from .collision_check import line_free
from .errors import MotionError
from .kinematics import IKResult, InverseKinematics
from .tool_line import ToolLine, line_path

_STARTS = (1, 8)  # few first: mostly the nearest serves


def choose_configurations(
    ik: InverseKinematics,
    targets: pin.SE3 | Sequence[pin.SE3],
    q0: np.ndarray,
    *,
    margin: float,
    approach: float = 0.0,
    world: CollisionWorld | None = None,
) -> list[IKResult]:
    """Choose configurations to go to, the nearest to where the arm is first.

    Args:
        ik: Inverse kinematics of the arm.
        targets: Pose of the tool in the world, or several that serve equally well.
        q0: Where the arm is.  # (nq,)
        margin: How far from the joint limits to stay where that is possible [rad].
        approach: How far the tool shall be able to go on from there, straight along its z axis,
            keeping that margin and touching nothing [m]. Where no configuration allows all of
            that, the one with the widest margin is taken, or else the nearest.
        world: What the arm shall not touch where that can be helped; None looks at nothing.

    Returns:
        At least one. When nothing is solved, the best attempt is the only one.

    Raises:
        MotionError: When a pose is none.
    """
    if world is not None:
        world.refresh()
    best: tuple[float, IKResult] | None = None
    for starts in _STARTS if approach else ():
        for found in ik.solutions(targets, q0, starts=starts, margin=margin):
            if world is not None and world.near(found.q):
                continue
            left = _margin_left(ik, found.q, approach, world)
            if left >= margin:
                return [found]
            if left > 0.0 and (best is None or left > best[0]):
                best = (left, found)
    if best is not None:
        return [best[1]]
    nearest = ik.nearest(targets, q0, margin=margin)
    if world is None or not nearest.solved:
        return [nearest]
    others = ik.solutions(targets, q0, starts=_STARTS[-1], margin=0.0)
    free = [found for found in (nearest, *others) if not world.near(found.q)]
    return free or [nearest]


def _margin_left(
    ik: InverseKinematics, q: np.ndarray, approach: float, world: CollisionWorld | None
) -> float:
    """Give how far the joints stay from their limits on the way on, negative when there is none."""
    T = ik.model.pose(q)
    line = ToolLine(T, T * pin.SE3(np.eye(3), np.array([0.0, 0.0, approach])))
    try:
        path = line_path(ik, q, line)
    except MotionError:
        return -1.0
    if world is not None and not line_free(world, path, line):
        return -1.0
    on_the_way = path.knots[:, : ik.model.nq]
    limits = ik.model.limits
    return float(min((on_the_way - limits.lower).min(), (limits.upper - on_the_way).min()))
