"""Collision checks of goals, tool paths and trajectories, with errors that name the bodies."""

from collections.abc import Iterable

import numpy as np

from bt_manip.collision import PATH_STEP, CollisionPair, CollisionWorld, FreeSpace
from bt_manip.exceptions import MotionError
from bt_manip.trajectories import CONTROL_STEP, Path, SplinePath, Trajectory

from .tool_path import ToolPath

TOOL_PATH_CLEARANCE = 1e-3  # [m] that tool paths keep: their geometry is given by the request


def collision_free_goals(
    world: CollisionWorld, start: np.ndarray, goals: Iterable[np.ndarray]
) -> list[np.ndarray]:
    """Return the goal configurations at which the arm is collision-free.

    Args:
        world: The collision world.
        start: Configuration of the arm; contacts that it has there do not count [rad].  # (nq,)
        goals: Configurations [rad].  # (nq,) each
    """
    space = FreeSpace(world, start, clearance=0.0)
    return [q for q in goals if space.is_free(q)]


def check_goals(
    world: CollisionWorld, start: np.ndarray, goals: Iterable[np.ndarray]
) -> list[np.ndarray]:
    """Return the goal configurations at which the arm is collision-free, at least one.

    Raises:
        MotionError: When there is none, with the deepest contact at the first goal.
    """
    goals = list(goals)
    free = collision_free_goals(world, start, goals)
    if not free:
        deepest = [world.collisions(q)[0] for q in goals]
        pair = next((pair for pair in deepest if world.other_robot(pair.second)), deepest[0])
        raise collision_error(
            world,
            pair,
            f"the target is in collision: '{pair.first}' would be "
            f"{-1e3 * pair.distance:.1f} mm inside '{pair.second}'",
        )
    return free


def check_tool_path(
    world: CollisionWorld, curve: SplinePath, path: ToolPath, *, fine: bool = True
) -> None:
    """Check that joints following a tool path are collision-free.

    Args:
        world: The collision world.
        curve: Joint path that follows the tool path.
        path: The tool path, for the message.
        fine: Whether to check every `PATH_STEP`, as a motion must be before it is executed; at the
            knots otherwise, a tenth of the checks, to compare candidates.

    Raises:
        MotionError: With the pair of bodies, and the fraction of the path that is free.
    """
    rows = sample_path(curve, 200) if fine else curve.knots
    configurations, fractions = rows[:, : curve.nq], rows[:, -1]
    start = configurations[0]
    space = FreeSpace(world, start, [configurations[-1]], clearance=TOOL_PATH_CLEARANCE)
    if fine:
        first = space.first_blocked(configurations)
    else:
        first = next((i for i, q in enumerate(configurations) if not space.is_free(q)), None)
    if first is None:
        return
    pair = space.nearest_pair(configurations[first])
    share, progress = path.progress(float(fractions[first]))
    message = f"the {path.name} is blocked after {progress}: {describe_pair(pair)}"
    raise collision_error(world, pair, message + describe_start(world, start), share)


def trajectory_is_free(world: CollisionWorld, trajectory: Trajectory, end: np.ndarray) -> bool:
    """Tell whether a trajectory is collision-free at every control step and every `PATH_STEP`.

    Args:
        world: The collision world.
        trajectory: Starts at the present reference.
        end: Its last configuration [rad].  # (nq,)
    """
    n = int(np.ceil(trajectory.duration / CONTROL_STEP)) + 1
    q = trajectory.sample(np.linspace(0.0, trajectory.duration, n))[0]
    longest = np.abs(np.diff(q, axis=0)).max(initial=0.0)
    if longest > PATH_STEP:
        n = int(np.ceil(n * longest / PATH_STEP)) + 1
        q = trajectory.sample(np.linspace(0.0, trajectory.duration, n))[0]
    return FreeSpace(world, q[0], [end]).path_is_free(q)


def sample_path(path: Path, samples: int) -> np.ndarray:
    """Return the rows of a path at even parameters, at most `PATH_STEP` apart in each joint.

    Args:
        path: A path in joint space.
        samples: Number of samples to find the largest slope with.
    """  # (n, m)
    slopes = path.evaluate(np.linspace(0.0, 1.0, samples), 1)[1][:, : path.nq]
    n = max(8, int(np.ceil(1.02 * np.abs(slopes).max() / PATH_STEP)))
    return path.evaluate(np.arange(n + 1) / n, 0)[0]


def collision_error(
    world: CollisionWorld, pair: CollisionPair | None, message: str, fraction: float | None = None
) -> MotionError:
    """Return the error for a collision; its reason is "robot" for another robot, which may move.

    Args:
        world: The collision world.
        pair: The colliding bodies, the arm's first; None where they are unknown.
        message: Text of the error, unless another robot is the obstacle.
        fraction: Share of a path that is free.
    """
    robot = world.other_robot(pair.second) if pair else ""
    if not pair or not robot:
        return MotionError(message, reason="collision", fraction=fraction)
    return MotionError(f"'{robot}' blocks '{pair.first}'", reason="robot", fraction=fraction)


def describe_pair(pair: CollisionPair | None) -> str:
    """Return the part of an error message that names the colliding bodies."""
    return "an obstacle" if pair is None else f"'{pair.first}' would touch '{pair.second}'"


def describe_start(world: CollisionWorld, start: np.ndarray) -> str:
    """Return the part of an error message about a collision at the start; empty without one."""
    pairs = world.collisions(start)
    if not pairs:
        return ""
    first, second, distance = pairs[0]
    return f"; at the start '{first}' is {-1e3 * distance:.1f} mm inside '{second}'"
