"""Values that the leaves of MoveIt Pro pass on: poses, joint states, motions, tasks."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeVar

import pinocchio as pin

from bt_manip import spatial

Kind = TypeVar("Kind")


def expect(value: object, kind: type[Kind]) -> Kind:
    """Return a value of a class.

    Raises:
        ValueError: If it is of another one.
    """
    if not isinstance(value, kind):
        raise ValueError(f"a {kind.__name__} is expected, not {type(value).__name__}")
    return value


@dataclass(frozen=True)
class PoseStamped:
    """A pose in a frame.

    Attributes:
        frame: The name of the frame.
        position: [m]  # (3,)
        orientation: Quaternion x, y, z, w.  # (4,)
    """

    frame: str = "world"
    position: tuple[float, ...] = (0.0, 0.0, 0.0)
    orientation: tuple[float, ...] = (0.0, 0.0, 0.0, 1.0)

    @property
    def T(self) -> pin.SE3:
        """The transform from the pose to its frame."""
        return transform(self.position, self.orientation)

    @classmethod
    def of(cls, frame: str, T: pin.SE3) -> "PoseStamped":
        """Return a transform as a pose in a frame."""
        w, x, y, z = map(float, spatial.quat_wxyz(T))
        return cls(frame, tuple(map(float, T.translation)), (x, y, z, w))

    @classmethod
    def from_message(cls, message: Any) -> "PoseStamped":
        """Read a PoseStamped message, as a mapping.

        Raises:
            ValueError: If it is none.
        """
        try:
            pose = message["pose"]
            position, orientation = pose["position"], pose["orientation"]
            frame = (message.get("header") or {}).get("frame_id") or "world"
            return cls(
                str(frame),
                tuple(float(position[axis]) for axis in "xyz"),
                tuple(float(orientation[axis]) for axis in "xyzw"),
            )
        except (KeyError, TypeError, AttributeError) as error:
            raise ValueError(f"a PoseStamped message is expected: {error!r}") from None

    def as_message(self) -> dict[str, Any]:
        """Return the fields of a PoseStamped message."""
        return {
            "header": {"frame_id": self.frame, "stamp": {"sec": 0, "nanosec": 0}},
            "pose": {
                "position": dict(zip("xyz", self.position, strict=True)),
                "orientation": dict(zip("xyzw", self.orientation, strict=True)),
            },
        }


def transform(position: Sequence[float], orientation: Sequence[float]) -> pin.SE3:
    """Return the transform of a position [m] and a quaternion x, y, z, w.

    Raises:
        ValueError: If there are not 3 and 4 numbers, or the quaternion is zero.
    """
    if len(position) != 3 or len(orientation) != 4:
        raise ValueError("a pose has 3 numbers for its position and 4 for its orientation")
    x, y, z, w = orientation
    if x == y == z == w == 0.0:
        raise ValueError("a quaternion is not zero")
    return spatial.pose(position, (w, x, y, z))


@dataclass(frozen=True)
class JointState:
    """Positions of joints by their names [rad]."""

    positions: Mapping[str, float] = field(default_factory=dict)

    def configuration(self, joints: Sequence[str], *hints: str) -> tuple[float, ...]:
        """Return the positions of an arm's joints, in their order [rad].

        Other joints, of a rail, a mobile base, a gripper or another arm, are left out. The names of
        all joints of the arm may have one prefix (``fr3_joint1`` for ``joint1``); of several such
        prefixes, the one counts that begins with a hint and ``_``: the name of the robot, or the
        first word of the group of joints.

        Raises:
            ValueError: If there is no position for a joint, or more than one.
        """
        prefixes = [
            prefix
            for prefix in (name.removesuffix(joints[0]) for name in self.positions)
            if all(prefix + joint in self.positions for joint in joints)
        ]
        if "" in prefixes:
            prefixes = [""]
        if len(prefixes) > 1:
            begins = tuple(f"{hint}_" for hint in hints if hint)
            prefixes = [prefix for prefix in prefixes if prefix.startswith(begins)]
        if not prefixes:
            raise ValueError(
                f"the joint state is not of the joints {', '.join(joints)}; it has "
                f"{', '.join(self.positions)}"
            )
        return tuple(self.positions[prefixes[0] + joint] for joint in joints)


@dataclass(frozen=True)
class Motion:
    """A motion of one arm; exactly one of `q`, `pose` and `path` is given.

    Attributes:
        q: Joint positions at its end [rad]; planned around obstacles.
        pose: Pose of the tool in the world at its end; planned likewise.
        path: Poses of the tool in the world that it passes on straight lines.
        approach: Length of the straight approach that follows [m].
        blend: Distance from a corner of the path at which its rounding begins [m].
        speed: Fraction of the limits of the arm.
    """

    q: tuple[float, ...] = ()
    pose: pin.SE3 | None = None
    path: tuple[pin.SE3, ...] = ()
    approach: float = 0.0
    blend: float = 0.0
    speed: float = 1.0


@dataclass(frozen=True)
class Plan:
    """Motions of an arm, one after the other: a trajectory, or the solution of a task."""

    motions: tuple[Motion, ...] = ()
