"""Fields of ROS messages: as objects, or as mappings with the names of their fields."""

import math
from collections.abc import Mapping, Sequence
from typing import Any


def field(message: Any, path: str, default: Any = None) -> Any:
    """Return a field of a message.

    Args:
        message: A mapping or an object.
        path: The names of the fields that lead to it, with dots between them.
        default: The result where a field is missing.
    """
    for name in path.split("."):
        if isinstance(message, Mapping):
            message = message.get(name)
        else:
            message = getattr(message, name, None)
        if message is None:
            return default
    return message


def stamp_of(message: Any) -> float:
    """Return the time [s] of a message's header, 0 for one without a time."""
    stamp = field(message, "header.stamp", 0.0)
    if isinstance(stamp, int | float):
        return float(stamp)
    return float(field(stamp, "sec", 0)) + 1e-9 * float(field(stamp, "nanosec", 0))


def position_of(pose: Any) -> tuple[float, ...]:
    """Return the position [m] of a Pose, of a PoseStamped, or of a list of coordinates.

    Raises:
        ValueError: If there is no position in it.
    """
    if isinstance(pose, Sequence) and not isinstance(pose, str):
        return tuple(float(number) for number in pose[:3])
    point = field(pose, "pose.position") or field(pose, "position")
    if point is None:
        raise ValueError("a pose needs a position")
    return tuple(float(field(point, axis, 0.0)) for axis in "xyz")


def poses_of(path: Any) -> list[Any]:
    """Return the poses of a Path message, or those of a list."""
    poses = path if isinstance(path, list | tuple) else field(path, "poses", [])
    return list(poses)


def length_of(path: Sequence[Any]) -> float:
    """Return the length [m] of the straight segments between poses."""
    points = [position_of(pose) for pose in path]
    return sum(math.dist(*pair) for pair in zip(points, points[1:], strict=False))
