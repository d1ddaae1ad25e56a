"""Whole motions, from whatever the arm is doing to rest at the target."""

from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple

import numpy as np

from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import InverseKinematics
from bt_manip.planning import (
    Planner,
    Step,
    check_path,
    check_targets,
    follow_path,
    free_targets,
    plan_collision_free_motion,
    tool_paths,
    trajectory_is_free,
)
from bt_manip.robots import RobotModel
from bt_manip.trajectories import (
    JointTrajectory,
    KinematicLimits,
    SequenceTrajectory,
    TailTrajectory,
    Trajectory,
    joint_profiles,
    limit_use,
    plan_stop,
    scale_to_effort_limits,
    time_parameterize,
    time_parameterize_segment,
)

NEAR = 0.2  # [rad] from a target that moves, where an arm may come to rest on its way to it
_STANDSTILL = 1e-10  # [rad] below which there is nothing to move; Ruckig gives up below 1e-12


class Present(NamedTuple):
    """What the reference does now, or would do now at full pace.

    Attributes:
        q: Position [rad].  # (nq,)
        v: Velocity [rad/s].  # (nq,)
        a: Acceleration [rad/s2].  # (nq,)
        trajectory: What it follows; None at rest.
        time: Since the start of that [s].
        pace: What part of that velocity it really has.
        change: How that changes [1/s].
    """

    q: np.ndarray
    v: np.ndarray
    a: np.ndarray
    trajectory: Trajectory | None
    time: float
    pace: float = 1.0
    change: float = 0.0


class CollisionAvoidance(NamedTuple):
    """How a motion keeps from touching anything.

    Attributes:
        world: What there is.
        planner: Finds ways around.
        rng: What it draws from.
    """

    world: CollisionWorld
    planner: Planner
    rng: np.random.Generator


def plan_stop_from(present: Present, model: RobotModel) -> Trajectory | None:
    """Plan to come to rest; None where the arm is at rest."""
    if present.trajectory is None:
        return None
    return plan_stop(present.trajectory, present.time, model)


def plan_to_configurations(
    present: Present,
    targets: Iterable[np.ndarray],
    model: RobotModel,
    speed: float,
    avoiding: CollisionAvoidance | None,
    *,
    follows: bool = False,
) -> Trajectory | None:
    """Plan to one of several configurations; None where the arm already stands there.

    From rest the joints move in phase, on the straight line, or around what is in the way. In
    motion they turn towards the first target in the shortest time in which all can arrive
    together; where that would leave the limits or touch something, the arm stops first.

    An arm that follows does not stop on a way around that leads near to the target: else it would
    stop and set out again as often as it is told where the target is.

    Args:
        present: What the reference does now.
        targets: Where it may go, the best first; no more of them are asked for than are needed.
            # (nq,) each
        model: The arm with its payload.
        speed: At 0.5 a move from rest takes twice the time.
        avoiding: How to keep from touching anything; None does not look.
        follows: Whether it may go on as it does; then None says so.

    Raises:
        MotionError: When all targets or all ways are blocked, or ask too much effort.
    """
    others = iter(targets)
    target = next(others)
    if avoiding is not None and not free_targets(avoiding.world, present.q, [target]):
        target, *kept = check_targets(avoiding.world, present.q, [target, *others])
        others = iter(kept)

    def from_rest(q: np.ndarray) -> Trajectory | None:
        if np.abs(target - q).max() < _STANDSTILL:
            return None
        if avoiding is None:
            return time_parameterize_segment(q, target, model, speed)
        world, planner, rng = avoiding
        return plan_collision_free_motion(q, target, others, world, model, speed, planner, rng)

    if present.trajectory is None:
        return from_rest(present.q)
    turned = _turned(present, target, model, speed)
    if turned is not None and (
        avoiding is None or trajectory_is_free(avoiding.world, turned, target)
    ):
        return turned
    if follows and avoiding is not None and _leads_near(present, target, avoiding.world):
        return None
    return _after_stop(present, model, from_rest)


def _leads_near(present: Present, target: np.ndarray, world: CollisionWorld) -> bool:
    """Tell whether what a moving arm is doing brings it near to a target, and is free still."""
    if present.trajectory is None or np.abs(present.trajectory.end - target).max() > NEAR:
        return False
    rest = TailTrajectory(present.trajectory, present.time)
    return trajectory_is_free(world, rest, rest.end)


def _turned(
    present: Present, target: np.ndarray, model: RobotModel, speed: float
) -> JointTrajectory | None:
    """Turn a moving arm towards a target; None where that leaves the limits."""
    limits = model.limits
    state = (present.q, present.v, present.a)

    def turn(factor: float) -> JointTrajectory:
        acceleration, jerk = factor * limits.acceleration, factor * limits.jerk
        return JointTrajectory(
            joint_profiles(state, target, speed * limits.velocity, acceleration, jerk)
        )

    try:
        turned = scale_to_effort_limits(turn, model)
    except MotionError:
        return None
    return turned if limit_use(turned, limits).inside else None


def plan_tool_path(
    present: Present,
    steps: Sequence[Step],
    blend: float,
    model: RobotModel,
    ik: InverseKinematics,
    speed: float,
    world: CollisionWorld | None,
) -> Trajectory | None:
    """Plan a path of the tool, from where the arm comes to rest.

    Args:
        present: What the reference does now.
        steps: Lines and arcs of the tool.
        blend: How far from a corner it is rounded [m]; at 0 the tool halts there.
        model: The arm with its payload.
        ik: Its inverse kinematics.
        speed: At 0.5 it takes twice the time.
        world: What is not to be touched; None does not look.

    Raises:
        MotionError: When the path cannot be followed, touches something, or asks too much effort.
    """

    def along(q: np.ndarray) -> Trajectory | None:
        curves = []
        for path in tool_paths(model.pose(q), steps, blend):
            curve = follow_path(ik, q, path)
            if world is not None:
                check_path(world, curve, path)
            bounds = path.bounds(KinematicLimits.of_joints(model.limits), model.tool_limits)
            curves.append((curve, bounds, path.grids))
            q = curve.end
        driven = [
            time_parameterize(curve, bounds, model, speed, grids) for curve, bounds, grids in curves
        ]
        return SequenceTrajectory(driven) if len(driven) > 1 else next(iter(driven), None)

    return _after_stop(present, model, along)


def _after_stop(
    present: Present, model: RobotModel, then: Callable[[np.ndarray], Trajectory | None]
) -> Trajectory | None:
    stop = plan_stop_from(present, model)
    motion = then(present.q if stop is None else stop.end)
    if stop is None or motion is None:
        return stop or motion
    return SequenceTrajectory([stop, motion])
