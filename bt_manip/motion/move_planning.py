"""Whole motions, from whatever the arm is doing to rest at the target."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.robots import RobotModel

from .bounds import Bounds
from .braking import brake
from .driving import drive, drive_straight
from .effort import within_effort
from .errors import MotionError
from .inverse_kinematics import InverseKinematics
from .jerk_profile import joint_profiles
from .limit_check import limit_use
from .tool_line import ToolLine, line_path
from .trajectory import JointTrajectory, SequenceTrajectory, Trajectory

_SAME = 1e-9  # [m] and [rad]
_STANDSTILL = 1e-10  # [rad] below which there is nothing to move; Ruckig gives up below 1e-12


class Present(NamedTuple):
    """What the reference does now.

    Attributes:
        q: Position [rad].  # (nq,)
        v: Velocity [rad/s].  # (nq,)
        a: Acceleration [rad/s2].  # (nq,)
        trajectory: What it follows; None at rest.
        time: Since the start of that [s].
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    trajectory: Trajectory | None
    time: float


def plan_stop(present: Present, model: RobotModel) -> Trajectory | None:
    """Plan to come to rest; None where the arm is at rest."""
    if present.trajectory is None:
        return None
    state = (present.q, present.v, present.a)
    return brake(present.trajectory, present.time, state, model)


def plan_to_configuration(
    present: Present, target: np.ndarray, model: RobotModel, speed: float
) -> Trajectory | None:
    """Plan to a configuration; None where the arm already stands there.

    From rest the joints move in phase, on the straight line. In motion they turn towards the
    target in the shortest time in which all can arrive together; where that would leave the
    limits, the arm stops first.

    Raises:
        MotionError: When the motion asks too much effort.
    """
    if present.trajectory is None:
        return _straight(present.q, target, model, speed)
    limits = model.limits
    state = (present.q, present.v, present.a)

    def turn(factor: float) -> JointTrajectory:
        acceleration, jerk = factor * limits.acceleration, factor * limits.jerk
        return JointTrajectory(
            joint_profiles(state, target, speed * limits.velocity, acceleration, jerk)
        )

    try:
        turned = within_effort(turn, model)
        if limit_use(turned, limits).inside:
            return turned
    except MotionError:
        pass
    return _after_stop(present, model, lambda q: _straight(q, target, model, speed))


def plan_line(
    present: Present, T_wt: pin.SE3, model: RobotModel, ik: InverseKinematics, speed: float
) -> Trajectory | None:
    """Plan a straight line of the tool, from where the arm comes to rest.

    Raises:
        MotionError: When the line cannot be followed, or asks too much effort.
    """

    def line_from(q: np.ndarray) -> Trajectory | None:
        line = ToolLine(model.pose(q), T_wt)
        if line.length < _SAME and line.angle < _SAME:
            return None
        bounds = line.bounds(Bounds.of_joints(model.limits), model.tool_limits)
        return drive(line_path(ik, q, line), bounds, model, speed)

    return _after_stop(present, model, line_from)


def _after_stop(
    present: Present, model: RobotModel, then: Callable[[np.ndarray], Trajectory | None]
) -> Trajectory | None:
    stop = plan_stop(present, model)
    motion = then(present.q if stop is None else stop.end)
    if stop is None or motion is None:
        return stop or motion
    return SequenceTrajectory([stop, motion])


def _straight(
    start: np.ndarray, end: np.ndarray, model: RobotModel, speed: float
) -> Trajectory | None:
    if np.abs(end - start).max() < _STANDSTILL:
        return None
    return drive_straight(start, end, model, speed)
