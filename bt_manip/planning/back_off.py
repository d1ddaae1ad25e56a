"""Motions back along a path just travelled."""

from collections.abc import Iterable
from itertools import dropwhile

import numpy as np

from bt_manip.collision import CollisionWorld, FreeSpace
from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotModel
from bt_manip.trajectories import Trajectory, time_parameterize

from .collision_check import TOOL_PATH_CLEARANCE, collision_error, describe_pair, sample_path
from .path_simplification import smooth_paths


def plan_back_off(
    q: np.ndarray,
    travelled: np.ndarray,
    distance: float,
    world: CollisionWorld | None,
    model: RobotModel,
    speed: float,
) -> Trajectory:
    """Plan a motion back along a travelled path, from rest to rest.

    Args:
        q: Present configuration, near the path [rad].  # (nq,)
        travelled: Configurations of the path, at least one, the last first [rad].  # (n, nq)
        distance: Travel of the tool [m]; a shorter path is followed to its end.
        world: The collision world; None does not check.
        model: The arm with its payload.
        speed: At 0.5 the motion takes twice the time.

    Raises:
        MotionError: When there is no such path, or something blocks it.
    """
    # The nearest configuration may lie ahead, and those after it still inside an obstacle.
    nearest = int(np.abs(travelled - q).max(axis=1).argmin())
    older = list(travelled[nearest + 1 :])
    if world is not None:
        touching = FreeSpace(world, q, clearance=0.0)
        older = list(dropwhile(lambda row: not touching.is_free(row), older))
    waypoints = _waypoints(q, older, distance, model)
    if len(waypoints) < 2:
        raise MotionError("there is no travelled path to back off along", reason="target")
    *_, path = smooth_paths(waypoints)  # the one nearest to the waypoints
    if world is not None:
        space = FreeSpace(world, q, [waypoints[-1]], clearance=TOOL_PATH_CLEARANCE)
        rows = sample_path(path, 400)[:, : path.nq]
        blocked = space.first_blocked(rows)
        if blocked is not None:
            pair = space.nearest_pair(rows[blocked])
            message = f"the path back is blocked: {describe_pair(pair)}"
            raise collision_error(world, pair, message)
    return time_parameterize(path, model, speed)


def _waypoints(
    q: np.ndarray, path: Iterable[np.ndarray], distance: float, model: RobotModel
) -> np.ndarray:
    """Return the present configuration and the part of a path that moves the tool so far."""
    found, left = [q], distance
    tool = model.pose(q).translation.copy()
    for row in path:
        position = model.pose(row).translation.copy()
        step = float(np.linalg.norm(position - tool))
        part = min(1.0, left / step) if step else 1.0
        found.append(found[-1] + part * (row - found[-1]))
        left, tool = left - step, position
        if left <= 0.0:
            break
    return np.array(found)  # (n, nq)
