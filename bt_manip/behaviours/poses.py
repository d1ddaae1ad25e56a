"""Poses in ports, poses of objects, and tool poses that point down."""

import math
from collections.abc import Iterable, Sequence

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.bt import Input, Output
from bt_manip.cell import Cell, as_object, bottom_of

QUARTER_TURN = math.pi / 2


def pose_from_text(text: str) -> pin.SE3:
    """Parse a pose.

    Args:
        text: ``x;y;z`` [m] with the world's orientation, ``x;y;z;qw;qx;qy;qz``, or ``x;y;z`` and
            the exact rotation matrix by rows.

    Raises:
        ValueError: If it is not three, seven or twelve finite numbers, or not a rotation.
    """
    try:
        numbers = [float(part) for part in text.split(";")]
    except ValueError:
        numbers = []
    if len(numbers) == 12:
        position, rotation = np.array(numbers[:3]), np.array(numbers[3:]).reshape(3, 3)
        if not np.isfinite(numbers).all() or not _is_rotation(rotation):
            raise ValueError(f"the last nine numbers of a pose are a rotation matrix, got '{text}'")
        return pin.SE3(rotation, position)
    if len(numbers) not in (3, 7):
        raise ValueError(f"a pose is 'x;y;z' or 'x;y;z;qw;qx;qy;qz' in metres, got '{text}'")
    return spatial.pose(numbers[:3], numbers[3:] or (1.0, 0.0, 0.0, 0.0))


def pose_to_text(T: pin.SE3) -> str:
    """Format a pose as text that parses to the same pose, bit for bit.

    The format is ``x;y;z;qw;qx;qy;qz`` if it is exact; otherwise it has the rotation matrix,
    because the conversion to a quaternion and back rounds.
    """
    text = _joined((*T.translation, *spatial.quat_wxyz(T)))
    if pose_from_text(text).rotation.tobytes() == T.rotation.tobytes():
        return text
    return _joined((*T.translation, *T.rotation.ravel()))


def _joined(numbers: Iterable[float]) -> str:
    return ";".join(repr(float(number)) for number in numbers)


def _is_rotation(rotation: np.ndarray) -> bool:
    """Return whether a matrix is a rotation, up to the precision of numbers in text."""
    orthogonal = np.abs(rotation @ rotation.T - np.eye(3)).max() < 1e-6
    return bool(orthogonal and np.linalg.det(rotation) > 0.0)


def pose_input(doc: str) -> Input:
    """Declare an input port for a pose."""
    return Input(pin.SE3, parse=pose_from_text, format=pose_to_text, doc=doc)


def pose_output(doc: str) -> Output:
    """Declare an output port for a pose."""
    return Output(pin.SE3, parse=pose_from_text, format=pose_to_text, doc=doc)


def poses_from_text(text: str) -> list[pin.SE3]:
    """Parse poses separated by ``|``.

    Raises:
        ValueError: If one of them is not a pose.
    """
    return [pose_from_text(part) for part in text.split("|")]


def poses_to_text(poses: Iterable[pin.SE3]) -> str:
    """Format poses as text that parses to the same poses, bit for bit, separated by ``|``."""
    return "|".join(map(pose_to_text, poses))


def poses_input(doc: str) -> Input:
    """Declare an input port for several poses."""
    return Input(list[pin.SE3], parse=poses_from_text, format=poses_to_text, doc=doc)


def poses_output(doc: str) -> Output:
    """Declare an output port for several poses, or none."""

    def parse(text: str) -> list[pin.SE3]:
        return poses_from_text(text) if text else []

    return Output(list[pin.SE3], parse=parse, format=poses_to_text, doc=doc)


def centre_pose(cell: Cell, name: str) -> pin.SE3:
    """Return the pose of an object's centre, which may differ from its origin.

    Raises:
        CellError: If there is no such object.
    """
    offset = as_object(cell.find(name)).centre_offset
    return cell.pose(name) * pin.SE3(np.eye(3), np.asarray(offset, dtype=float))


def bottom_pose(cell: Cell, name: str) -> pin.SE3:
    """Return the pose of the bottom centre of an upright object.

    Raises:
        CellError: If there is no such object.
    """
    return cell.pose(name) * bottom_of(cell.find(name))


def yaw_of(T: pin.SE3) -> float:
    """Return the yaw of a pose's most horizontal axis [rad].

    The most horizontal of its three axes is used because an object may lie on any of its faces.
    """
    axis = T.rotation[:, int(np.argmin(np.abs(T.rotation[2])))]
    return math.atan2(axis[1], axis[0])


def top_grasp_poses(T_wo: pin.SE3, height: float) -> list[pin.SE3]:
    """List the four tool poses pointing down over a box-like object, parallel to its sides.

    Args:
        T_wo: Pose of the object's centre in the world.
        height: Height of the tool centre point over the object's centre [m].

    Returns:
        Poses a quarter turn apart: each pair of opposite faces, in both directions.
    """
    position = T_wo.translation + np.array([0.0, 0.0, height])
    yaw = yaw_of(T_wo)
    return [spatial.pointing_down(position, yaw + k * QUARTER_TURN) for k in range(4)]


def downward_poses(position: Sequence[float], yaws: int = 8) -> list[pin.SE3]:
    """List tool poses pointing down at a position, with yaws over a full turn."""
    return [spatial.pointing_down(position, 2 * math.pi * k / yaws) for k in range(yaws)]


def nearest_orientation(poses: Sequence[pin.SE3], T: pin.SE3) -> pin.SE3:
    """Return the pose whose orientation is nearest to that of another pose."""
    return max(poses, key=lambda pose: float(np.trace(pose.rotation.T @ T.rotation)))
