"""Selection of a goal configuration for a tool pose, with an approach that continues from it."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import IKResult, InverseKinematics, Target
from bt_manip.trajectories import SplinePath

from .collision_check import check_tool_path
from .tool_path import LineTo, tool_paths
from .tool_path_following import QUICK_REFINEMENTS, follow_tool_path

_RESTARTS = (0, 1, 8)  # of inverse kinematics: few first, since the nearest solution usually serves


class StraightApproach(NamedTuple):
    """The result of following a straight line of the tool.

    Attributes:
        limit_margin: Least distance of a joint from its limits [rad]; -1 where the line cannot be
            followed.
        end: Configuration at the end of the line; the first one where it cannot be followed
            [rad].  # (nq,)
        error: Why it cannot be followed.
        curve: The joint path that follows it; None where the tool is at its end already.
    """

    limit_margin: float
    end: np.ndarray
    error: MotionError | None
    curve: SplinePath | None = None


def goal_configurations(
    ik: InverseKinematics,
    targets: pin.SE3 | Target | Sequence[pin.SE3 | Target],
    q0: np.ndarray,
    *,
    margin: float,
    approach: float = 0.0,
    world: CollisionWorld | None = None,
) -> Iterator[IKResult]:
    """Yield goal configurations for tool poses, the nearest to the present one first.

    Solutions are computed on demand, which must be before anything moves.

    Args:
        ik: Inverse kinematics of the arm.
        targets: Pose T_wt of the tool or a target, or several equivalent ones.
        q0: Present configuration [rad].  # (nq,)
        margin: Distance from the joint limits, where possible [rad].
        approach: Length of a straight, collision-free line along the tool's z axis that starts at
            the goal and keeps the margin [m]. Where no configuration allows all of that, the one
            with the widest margin is chosen, or else the nearest.
        world: Collision world; None does not check.

    Yields:
        At least one. When nothing is solved, the best attempt is the only one.

    Raises:
        MotionError: When a pose is invalid.
    """
    if world is not None:
        world.refresh()
    best: tuple[float, IKResult] | None = None
    for restarts in _RESTARTS if approach else ():
        for found in ik.nearest_first(targets, q0, restarts=restarts, margin=margin):
            if world is not None and world.collisions(found.q):
                continue
            T_end = translate_along_tool_z(ik.model.pose(found.q), approach)
            limit_margin = plan_straight_approach(ik, found.q, T_end, world).limit_margin
            if limit_margin >= margin:
                yield found
                return
            if limit_margin > 0.0 and (best is None or limit_margin > best[0]):
                best = (limit_margin, found)
    if best is not None:
        yield best[1]
        return
    # Restarts hardly ever find a nearer one: for eight equivalent poses of the tool, at most 0.4 %
    # nearer in 145 cases.
    first = next(ik.nearest_first(targets, q0, restarts=_RESTARTS[0], margin=margin), None)
    nearest = first or ik.nearest(targets, q0, margin=margin)
    yield nearest
    if world is not None and nearest.solved:
        yield from ik.nearest_first(targets, q0, restarts=_RESTARTS[-1], margin=0.0)


def plan_straight_approach(
    ik: InverseKinematics, q: np.ndarray, T_wt: pin.SE3, world: CollisionWorld | None
) -> StraightApproach:
    """Follow a straight line of the tool, collision-checked at the knots of the joint path.

    Args:
        ik: Inverse kinematics of the arm.
        q: Configuration at the start of the line [rad].  # (nq,)
        T_wt: Tool pose at its end.
        world: Collision world; None does not check.
    """
    configurations, curve = q[np.newaxis], None
    for line in tool_paths(ik.model.pose(q), [LineTo(T_wt)]):  # none where the tool is there
        try:
            curve = follow_tool_path(ik, q, line, QUICK_REFINEMENTS)
            if world is not None:
                check_tool_path(world, curve, line, fine=False)
        except MotionError as error:
            return StraightApproach(-1.0, q, error)
        configurations = curve.knots[:, : ik.model.nq]
    limits = ik.model.limits
    margin = min((configurations - limits.lower).min(), (limits.upper - configurations).min())
    return StraightApproach(float(margin), np.array(configurations[-1]), None, curve)


def translate_along_tool_z(T_wt: pin.SE3, distance: float) -> pin.SE3:
    """Return a tool pose translated along its z axis [m]."""
    return T_wt * pin.SE3(np.eye(3), np.array([0.0, 0.0, distance]))
