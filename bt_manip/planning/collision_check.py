"""Refuse motions that would touch something, and say what."""

from collections.abc import Iterable, Sequence

import numpy as np

from bt_manip.collision import PATH_STEP, CollisionPair, CollisionWorld, FreeSpace
from bt_manip.exceptions import MotionError
from bt_manip.trajectories import CONTROL_STEP, SplinePath, Trajectory

from .tool_path import ToolPath

LINE_CLEARANCE = 1e-3  # [m] of a line that was asked for as it is


def free_targets(
    world: CollisionWorld, start: np.ndarray, targets: Iterable[np.ndarray]
) -> list[np.ndarray]:
    """Leave out the targets at which the arm would touch something."""
    space = FreeSpace(world, start, clearance=0.0)
    return [q for q in targets if space.is_free(q)]


def check_targets(
    world: CollisionWorld, start: np.ndarray, targets: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """Leave out the targets at which the arm would touch something.

    Raises:
        MotionError: When none is left, naming what is in the way of the first.
    """
    kept = free_targets(world, start, targets)
    if not kept:
        found = [world.collisions(q)[0] for q in targets]
        near = next((near for near in found if world.other_robot(near.second)), found[0])
        raise collision_error(
            world,
            near,
            f"the target is inside an obstacle: '{near.first}' would be "
            f"{-1e3 * near.distance:.1f} mm inside '{near.second}'",
        )
    return kept


def collision_error(
    world: CollisionWorld, near: CollisionPair | None, message: str, fraction: float | None = None
) -> MotionError:
    """Make the error about something in the way; another robot may go away by itself.

    Args:
        world: What there is.
        near: What would come too near to what.
        message: What cannot be done.
        fraction: How much of a path is free.
    """
    robot = "" if near is None else world.other_robot(near.second)
    if not robot or near is None:
        return MotionError(message, reason="collision", fraction=fraction)
    message = f"'{robot}' blocks '{near.first}'"
    return MotionError(message, reason="robot", fraction=fraction)


def touched_at(world: CollisionWorld, start: np.ndarray) -> str:
    """Say what the arm is inside of where a motion starts; empty where it is in nothing."""
    near = world.collisions(start)
    if not near:
        return ""
    first, second, distance = near[0]
    return f"; at the start '{first}' is {-1e3 * distance:.1f} mm inside '{second}'"


def check_path(
    world: CollisionWorld, curve: SplinePath, path: ToolPath, *, closely: bool = True
) -> None:
    """Look at joints that follow a path of the tool.

    Args:
        world: What there is.
        curve: The joints' way.
        path: The tool's, for the message.
        closely: Whether to look at steps of `PATH_STEP`, as before a motion is executed; at its
            knots otherwise, to choose between ways with a tenth of the work.

    Raises:
        MotionError: Naming what it would touch, and how far it gets.
    """
    configurations, fractions = _fine(curve) if closely else _split(curve.knots, curve.nq)
    ends = (configurations[0], configurations[-1])
    space = FreeSpace(world, ends[0], ends[1:], clearance=LINE_CLEARANCE)
    if closely:
        first = space.first_blocked(configurations)
    else:
        first = next((i for i, q in enumerate(configurations) if not space.is_free(q)), None)
    if first is None:
        return
    near = space.blocker(configurations[first])
    what = "something is" if near is None else f"'{near.first}' would touch '{near.second}'"
    share, percent, metres = path.progress(float(fractions[first]))
    message = f"the {path.name} is blocked after {percent} ({metres}): {what}"
    message += touched_at(world, ends[0])
    raise collision_error(world, near, message, share)


def trajectory_is_free(world: CollisionWorld, trajectory: Trajectory, end: np.ndarray) -> bool:
    """Tell whether a trajectory from the present reference is free, as it will be driven."""
    n = int(np.ceil(trajectory.duration / CONTROL_STEP)) + 1
    q = trajectory.sample(np.linspace(0.0, trajectory.duration, n))[0]
    longest = np.abs(np.diff(q, axis=0)).max(initial=0.0)
    if longest > PATH_STEP:
        n = int(np.ceil(n * longest / PATH_STEP)) + 1
        q = trajectory.sample(np.linspace(0.0, trajectory.duration, n))[0]
    return FreeSpace(world, q[0], [end]).path_is_free(q)


def _fine(curve: SplinePath) -> tuple[np.ndarray, np.ndarray]:
    """Give a path's configurations at steps of `PATH_STEP`, and how far along each is."""
    slope = np.abs(curve.evaluate(np.linspace(0.0, 1.0, 200), 1)[1][:, : curve.nq]).max()
    n = max(8, int(np.ceil(1.02 * slope / PATH_STEP)))
    return _split(curve.evaluate(np.arange(n + 1) / n, 0)[0], curve.nq)


def _split(rows: np.ndarray, nq: int) -> tuple[np.ndarray, np.ndarray]:
    return rows[:, :nq], rows[:, -1]
