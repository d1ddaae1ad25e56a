"""Collision-free motions in joint space."""

from collections.abc import Iterable

import numpy as np

from bt_manip.collision import PATH_STEP, CollisionWorld, FreeSpace
from bt_manip.robots import RobotModel
from bt_manip.trajectories import (
    Path,
    SequenceTrajectory,
    Trajectory,
    limit_use,
    time_parameterize,
    time_parameterize_segment,
)

from .collision_check import (
    collision_error,
    collision_free_goals,
    describe_pair,
    describe_start,
    sample_path,
)
from .joint_segments import discretize_segment, edge_is_free
from .path_simplification import shortcut, smooth_paths
from .planner import Planner, PlanningProblem

PLANNING_ATTEMPTS = 5
PLANNING_CLEARANCE = 8e-3  # [m] larger than that of `FreeSpace`: leaves space for smoothing
COARSE_STEP = 0.2  # [rad] of the check before that at `PATH_STEP`, which finds most collisions


def plan_collision_free_motion(
    start: np.ndarray,
    goal: np.ndarray,
    others: Iterable[np.ndarray],
    world: CollisionWorld,
    model: RobotModel,
    speed: float,
    planner: Planner,
    rng: np.random.Generator,
) -> Trajectory:
    """Plan a collision-free motion from rest to rest at one of several goals.

    A straight segment is used where one is free. Otherwise the planner's path is shortcut, smoothed
    and time-parameterized, and checked every `PATH_STEP`.

    Args:
        start: Start configuration [rad].  # (nq,)
        goal: Preferred goal configuration, collision-free [rad].  # (nq,)
        others: Further goals, only evaluated where the segment to the preferred one is blocked
            [rad].  # (nq,) each
        world: The collision world.
        model: The arm with its payload.
        speed: At 0.5 the motion takes twice the time.
        planner: Finds paths around obstacles.
        rng: Random generator of the planner and of shortcutting.

    Raises:
        MotionError: When no path is found, or the motion needs too much effort.
    """
    space = FreeSpace(world, start, [goal])
    if segment_is_free(start, goal, space):
        return time_parameterize_segment(start, goal, model, speed)
    goals = [goal, *collision_free_goals(world, start, others)]
    space = FreeSpace(world, start, goals)
    for other in goals[1:]:
        if segment_is_free(start, other, space):
            return time_parameterize_segment(start, other, model, speed)
    wide = FreeSpace(world, start, goals, clearance=PLANNING_CLEARANCE)
    problem = PlanningProblem(start, np.array(goals), wide.is_free, model.limits, rng)
    stopping: Trajectory | None = None
    reason = "the paths that were found fail the fine collision check"
    for _ in range(PLANNING_ATTEMPTS):
        result = planner.plan(problem)
        if not len(result.path):
            reason = result.reason
            break
        waypoints = shortcut(result.path, wide.is_free, rng)
        trajectory = _smooth_trajectory(waypoints, space, model, speed)
        if trajectory is not None:
            return trajectory
        stopping = stopping or _stopping_trajectory(waypoints, space, model, speed)
    if stopping is not None:
        return stopping
    segment = discretize_segment(start, goal, COARSE_STEP)
    blocked = space.first_blocked(segment)
    pair = None if blocked is None else space.nearest_pair(segment[blocked])
    message = f"no collision-free path: {describe_pair(pair)}; {reason}"
    raise collision_error(world, pair, message + describe_start(world, start))


def segment_is_free(start: np.ndarray, end: np.ndarray, space: FreeSpace) -> bool:
    """Tell whether a segment is collision-free every `PATH_STEP`."""
    if not edge_is_free(start, end, space.is_free, COARSE_STEP):
        return False
    return space.path_is_free(discretize_segment(start, end, PATH_STEP))


def _smooth_trajectory(
    waypoints: np.ndarray, space: FreeSpace, model: RobotModel, speed: float
) -> Trajectory | None:
    """Follow waypoints with the widest corners that are free; None where no corners are."""
    for path in smooth_paths(waypoints):
        if _path_is_free(path, space):
            trajectory = time_parameterize(path, model, speed)
            if limit_use(trajectory, model.limits).inside:
                return trajectory
    return None


def _stopping_trajectory(
    waypoints: np.ndarray, space: FreeSpace, model: RobotModel, speed: float
) -> Trajectory | None:
    """Follow waypoints with a stop at each; None where a segment is not free."""
    segments = list(zip(waypoints, waypoints[1:], strict=False))
    if not all(segment_is_free(a, b, space) for a, b in segments):
        return None
    return SequenceTrajectory([time_parameterize_segment(a, b, model, speed) for a, b in segments])


def _path_is_free(path: Path, space: FreeSpace) -> bool:
    """Tell whether a path is collision-free every `PATH_STEP`."""
    configurations = sample_path(path, 400)[:, : path.nq]
    every = max(1, int(COARSE_STEP / PATH_STEP))  # most paths that are not free fail here already
    return all(map(space.is_free, configurations[::every])) and space.path_is_free(configurations)
