"""Motions in joint space that touch nothing."""

from collections.abc import Iterable

import numpy as np

from bt_manip.collision import PATH_STEP, CollisionPair, CollisionWorld, FreeSpace
from bt_manip.robots import RobotModel
from bt_manip.trajectories import (
    KinematicLimits,
    Path,
    SequenceTrajectory,
    Trajectory,
    limit_use,
    time_parameterize,
    time_parameterize_segment,
)

from .collision_check import collision_error, free_targets, touched_at
from .edges import edge_is_free, line
from .planner import Planner, PlanningProblem
from .shortcutting import shortcut
from .smoothing import smooth_paths

ATTEMPTS = 5
WIDE = 8e-3  # [m] clearance that is planned with; less is enough for what is driven
COARSE = 0.04  # [rad] between the configurations that are looked at first


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
    """Plan from rest to rest at one of several configurations, around what is in the way.

    Where the straight line to one of them is free, it is driven straight. What is given back has
    been looked at as it will be driven, at steps of `PATH_STEP`.

    Args:
        start: Where the arm is at rest.  # (nq,)
        goal: Where it goes, where it touches nothing.  # (nq,)
        others: Where else it may go; only asked for where the straight line to the first is not
            free.  # (nq,) each
        world: What there is.
        model: The arm with its payload.
        speed: At 0.5 the move takes twice the time.
        planner: Finds ways around.
        rng: What the planner draws from.

    Raises:
        MotionError: When no way is found, or it asks too much effort.
    """
    space = FreeSpace(world, start, [goal])
    if segment_is_free(start, goal, space):
        return time_parameterize_segment(start, goal, model, speed)
    goals = [goal, *free_targets(world, start, others)]
    space = FreeSpace(world, start, goals)
    for other in goals[1:]:
        if segment_is_free(start, other, space):
            return time_parameterize_segment(start, other, model, speed)
    wide = FreeSpace(world, start, goals, clearance=WIDE)
    problem = PlanningProblem(start, np.array(goals), wide.is_free, model.limits, rng)
    stopping: Trajectory | None = None
    reason = "looked at closely, the ways that were found are not free"
    for _ in range(ATTEMPTS):
        found = planner.plan(problem)
        if not len(found.path):
            reason = found.reason
            break
        waypoints = shortcut(found.path, wide.is_free, rng)
        trajectory = _smoothly_along(waypoints, space, model, speed)
        if trajectory is not None:
            return trajectory
        stopping = stopping or _with_stops_along(waypoints, space, model, speed)
    if stopping is not None:
        return stopping
    near = _blocker(start, goal, space)
    what = "something is in it" if near is None else f"{near.first} would touch {near.second}"
    inside = touched_at(world, start)
    raise collision_error(world, near, f"the way is blocked: {what}; {reason}{inside}")


def _smoothly_along(
    waypoints: np.ndarray, space: FreeSpace, model: RobotModel, speed: float
) -> Trajectory | None:
    """Drive along waypoints with rounded corners; None where that is not free."""
    bounds = KinematicLimits.of_joints(model.limits)
    for path in smooth_paths(waypoints):
        if _path_free(path, space):
            trajectory = time_parameterize(path, bounds, model, speed)
            if limit_use(trajectory, model.limits).inside:
                return trajectory
    return None


def _with_stops_along(
    waypoints: np.ndarray, space: FreeSpace, model: RobotModel, speed: float
) -> Trajectory | None:
    """Drive from waypoint to waypoint; None where that is not free."""
    parts = list(zip(waypoints, waypoints[1:], strict=False))
    if not all(segment_is_free(a, b, space) for a, b in parts):
        return None
    return SequenceTrajectory([time_parameterize_segment(a, b, model, speed) for a, b in parts])


def segment_is_free(start: np.ndarray, end: np.ndarray, space: FreeSpace) -> bool:
    """Tell whether the straight line is free, at steps of `PATH_STEP`."""
    if not edge_is_free(start, end, space.is_free, COARSE):
        return False
    return space.path_is_free(line(start, end, PATH_STEP))


def _path_free(path: Path, space: FreeSpace) -> bool:
    """Tell whether a path is free, at steps of `PATH_STEP`."""
    slope = np.abs(path.evaluate(np.linspace(0.0, 1.0, 400), 1)[1][:, : path.nq]).max()
    n = max(8, int(np.ceil(1.02 * slope / PATH_STEP)))
    places = np.arange(n + 1) / n
    configurations = path.evaluate(places, 0)[0][:, : path.nq]
    every = max(1, int(COARSE / PATH_STEP))  # coarsely first: that is where most paths fail
    return all(map(space.is_free, configurations[::every])) and space.path_is_free(configurations)


def _blocker(start: np.ndarray, end: np.ndarray, space: FreeSpace) -> CollisionPair | None:
    """Name what is in the way of the straight line."""
    between = line(start, end, COARSE)
    i = space.first_blocked(between)
    return None if i is None else space.blocker(between[i])
