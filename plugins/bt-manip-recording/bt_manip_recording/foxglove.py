"""The scene of a cell as messages of Foxglove's schemas: geometry, frames and log lines."""

import re
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from foxglove_schemas_protobuf.Color_pb2 import Color
from foxglove_schemas_protobuf.FrameTransforms_pb2 import FrameTransforms
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.Point3_pb2 import Point3
from foxglove_schemas_protobuf.Pose_pb2 import Pose
from foxglove_schemas_protobuf.Quaternion_pb2 import Quaternion
from foxglove_schemas_protobuf.SceneEntity_pb2 import SceneEntity
from foxglove_schemas_protobuf.SceneEntityDeletion_pb2 import SceneEntityDeletion
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from foxglove_schemas_protobuf.TriangleListPrimitive_pb2 import TriangleListPrimitive
from foxglove_schemas_protobuf.Vector3_pb2 import Vector3
from google.protobuf.timestamp_pb2 import Timestamp

from bt_manip.cell import WORLD
from bt_manip_recording.protobuf import NumberTemplate
from bt_manip_recording.visuals import CellScene, SceneSource, Triangles, VisualShape

if TYPE_CHECKING:
    from bt_manip_recording.mcap_file import McapFile

PATH_COLOUR = Color(r=0.1, g=0.5, b=0.9, a=1.0)

FOXGLOVE_PATH_THICKNESS = 3.0
"""Thickness of the line of a planned path [pixels]."""


def timestamp_of(nanoseconds: int) -> Timestamp:
    """Return simulated time as protobuf has it.

    Args:
        nanoseconds: Simulated time [ns].
    """
    seconds, nanos = divmod(nanoseconds, 1_000_000_000)
    return Timestamp(seconds=seconds, nanos=nanos)


def log_message(nanoseconds: int, level: str, name: str, message: str) -> bytes:
    """Return a serialized log line.

    Args:
        nanoseconds: Simulated time [ns].
        level: ``"INFO"``, ``"WARNING"`` or ``"ERROR"``.
        name: Source of the line.
        message: Text of the line.
    """
    log = Log(timestamp=timestamp_of(nanoseconds), name=name, message=message)
    log.level = Log.Level.Value(level)
    return log.SerializeToString()


class SceneMessages:
    """Frames and geometry of one compiled model.

    Args:
        model: The compiled model.
        data: Its data.
        entities: The entities by name.

    Attributes:
        scene: The scene that they describe.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        entities: Mapping[str, Any] | None = None,
    ) -> None:
        self.scene = CellScene(model, data, entities)
        self._data, self._frames = data, self.scene.frames
        bodies = np.arange(1, model.nbody)
        movable = bodies[model.body_weldid[bodies] != 0]
        # One range, which is read faster than single rows; fixed bodies in it do no harm.
        first, last = (movable[0], movable[-1] + 1) if len(movable) else (1, 1)
        self._movable = slice(int(first), int(last))
        self._fixed = np.setdiff1d(bodies, movable)
        self._xpos, self._xquat = data.xpos[self._movable], data.xquat[self._movable]
        self._movable_frames = tuple(self._frames[self._movable])

    def fixed_frames(self, nanoseconds: int) -> bytes:
        """Return a serialized FrameTransforms of the bodies that cannot move."""
        frames = [self._frames[body] for body in self._fixed]
        positions, rotations = self._data.xpos[self._fixed], self._data.xquat[self._fixed]
        return _transforms(frames, positions, rotations, nanoseconds).SerializeToString()

    def copy_poses(self) -> bytes:
        """Return the present poses of the other bodies, for `movable_frames`."""
        return self._xpos.tobytes() + self._xquat.tobytes()

    def movable_frames(self, times: Sequence[int], poses: Sequence[bytes]) -> np.ndarray:
        """Return serialized FrameTransforms of the other bodies, one per row.

        Args:
            times: Simulated times [ns].  # (n,)
            poses: Results of `copy_poses` then.  # (n,)
        """  # (n, bytes)
        numbers = np.frombuffer(b"".join(poses)).reshape(len(times), -1)
        return frame_messages(self._movable_frames, times, numbers)


def geometry_message(shapes: Mapping[str, Sequence[VisualShape]], nanoseconds: int) -> bytes:
    """Return a serialized SceneUpdate with shapes, given by the frame of their body."""
    update = SceneUpdate()
    for frame, some in shapes.items():
        body = update.entities.add(
            timestamp=timestamp_of(nanoseconds), frame_id=frame, id=frame, frame_locked=True
        )
        for shape in some:
            _add_shape(body, shape)
    return update.SerializeToString()


def add_scene(
    file: "McapFile", scene: SceneSource, shown: Mapping[str, Any], nanoseconds: int
) -> Mapping[str, Any]:
    """Add the shapes of entities that are new or look different, and the removal of others.

    Args:
        file: The recording.
        scene: The scene.
        shown: The entities that the recording shows, with what identifies their appearance.
        nanoseconds: Simulated time [ns].

    Returns:
        The entities that it shows now.
    """
    present = scene.entities()
    for name in [name for name in shown if name not in present]:
        file.add(f"/scene/{name}", nanoseconds, removal())
    for name, appearance in present.items():
        if shown.get(name) != appearance:
            file.add_topic(f"/scene/{name}", SceneUpdate)
            message = geometry_message(scene.shapes(name), nanoseconds)
            file.add(f"/scene/{name}", nanoseconds, message)
    return dict(present)


def cameras_of(scene: SceneSource) -> dict[str, Any]:
    """Return the cameras, and the centre [m] and the size [m] of a scene, as plain data."""
    cameras = [
        {**one._asdict(), "position": one.position.tolist(), "quat_wxyz": one.quat_wxyz.tolist()}
        for one in scene.cameras
    ]
    return {"cameras": cameras, "centre": scene.centre.tolist(), "extent": scene.extent}


def frame_messages(
    frames: tuple[str, ...], times: Sequence[int], numbers: np.ndarray
) -> np.ndarray:
    """Return serialized FrameTransforms, one per row.

    Args:
        frames: Names of the frames.
        times: Simulated times [ns].  # (n,)
        numbers: All positions [m], then all quaternions (wxyz), at each time.  # (n, 7 frames)
    """  # (n, bytes)
    template, starts = frame_template(frames)
    data = template.serialize(numbers)
    for offset, part in zip(
        STAMP_PARTS, np.divmod(times, 1_000_000_000, dtype=np.int64), strict=True
    ):
        digits = part[:, None] >> 7 * np.arange(STAMP_DIGITS) & 0x7F
        digits[:, :-1] |= 0x80  # more digits follow
        for start in starts:
            data[:, start + offset : start + offset + STAMP_DIGITS] = digits
    return data


def _transforms(
    frames: Sequence[str], positions: np.ndarray, rotations: np.ndarray, nanoseconds: int
) -> FrameTransforms:
    """Return the poses of frames in the world: positions [m], and quaternions (wxyz)."""
    message = FrameTransforms()
    for frame, position, rotation in zip(frames, positions, rotations, strict=True):
        pose = _pose(position, rotation)
        message.transforms.add(
            timestamp=timestamp_of(nanoseconds),
            parent_frame_id=WORLD,
            child_frame_id=frame,
            translation=pose.position,
            rotation=pose.orientation,
        )
    return message


STAMP_DIGITS = 5
"""Bytes of each number of a time stamp: protobuf reads leading zeros, so all stamps are as long."""

STAMP_PARTS = 1, 2 + STAMP_DIGITS
"""Positions of seconds and nanoseconds in a serialized time stamp: each follows its tag."""


@lru_cache(64)
def frame_template(frames: tuple[str, ...]) -> tuple[NumberTemplate, list[int]]:
    """Return the template of FrameTransforms, and the positions of the time stamps in it.

    Its numbers are all positions [m] and then all quaternions (wxyz). The same frames return when
    objects come and go.

    Args:
        frames: Names of the frames.
    """
    n = len(frames)
    # The largest numbers of as many bytes; Timestamp is of the same wire format.
    longest = (1 << 34) * 1_000_000_000 + 999_999_999

    def build(numbers: Sequence[float]) -> FrameTransforms:
        positions = np.reshape(numbers[: 3 * n], (n, 3))
        rotations = np.reshape(numbers[3 * n :], (n, 4))
        return _transforms(frames, positions, rotations, longest)

    template = NumberTemplate(build, 7 * n)
    stamp = re.escape(timestamp_of(longest).SerializeToString())
    starts = [found.start() for found in re.finditer(stamp, template.data)]
    assert len(starts) == n
    return template, starts


def _add_shape(body: SceneEntity, shape: VisualShape) -> None:
    pose = _pose(shape.position, shape.quat_wxyz)
    colour = Color(**dict(zip("rgba", shape.rgba, strict=True)))
    size = Vector3(**dict(zip("xyz", shape.size, strict=True)))
    if shape.triangles is not None:
        vertices, faces = shape.triangles
        triangles = body.triangles.add(pose=pose, indices=faces.ravel().tolist(), color=colour)
        triangles.MergeFromString(serialized_points(vertices))
    elif shape.kind == "box":
        body.cubes.add(pose=pose, size=size, color=colour)
    elif shape.kind == "ellipsoid":
        body.spheres.add(pose=pose, size=size, color=colour)
    else:
        body.cylinders.add(pose=pose, size=size, bottom_scale=1.0, top_scale=1.0, color=colour)


def shapes_of(update: SceneUpdate) -> dict[str, list[VisualShape]]:
    """Return the shapes of a SceneUpdate, by the frame of their body."""
    found: dict[str, list[VisualShape]] = {}
    for body in update.entities:
        shapes = found.setdefault(body.frame_id, [])
        kinds = {"box": body.cubes, "ellipsoid": body.spheres, "cylinder": body.cylinders}
        for kind, primitives in kinds.items():
            shapes += [_shape(kind, one, one.size) for one in primitives]
        for one in body.triangles:
            vertices = np.array([(p.x, p.y, p.z) for p in one.points], dtype=np.float32)
            faces = np.array(one.indices, dtype=np.int64).reshape(-1, 3)
            if faces.max(initial=-1) >= len(vertices):
                raise ValueError("a triangle has a corner that is not there")
            shapes.append(_shape("mesh", one, None, Triangles(vertices.reshape(-1, 3), faces)))
    return found


def _shape(kind: Any, primitive: Any, size: Any, triangles: Triangles | None = None) -> VisualShape:
    p, q, c = primitive.pose.position, primitive.pose.orientation, primitive.color
    return VisualShape(
        kind,
        np.array([p.x, p.y, p.z]),
        np.array([q.w, q.x, q.y, q.z]),
        (c.r, c.g, c.b, c.a),
        (1.0, 1.0, 1.0) if size is None else (size.x, size.y, size.z),
        triangles,
    )


def serialized_points(points: np.ndarray) -> bytes:
    """Return a serialized TriangleListPrimitive with some points and nothing else.

    Args:
        points: The points [m].  # (n, 3)
    """

    def build(numbers: Sequence[float]) -> TriangleListPrimitive:
        x, y, z = numbers
        return TriangleListPrimitive(points=[Point3(x=x, y=y, z=z)])

    return NumberTemplate(build, 3).serialize(points).tobytes()


def path_line(name: str, nanoseconds: int, points: np.ndarray) -> bytes:
    """Return a serialized SceneUpdate that draws a line in the world until its removal.

    Args:
        name: Name of the robot that plans the path.
        nanoseconds: Simulated time [ns].
        points: Its points [m].  # (n, 3)
    """
    update = SceneUpdate()
    entity = update.entities.add(timestamp=timestamp_of(nanoseconds), frame_id=WORLD, id=name)
    line = entity.lines.add(
        thickness=FOXGLOVE_PATH_THICKNESS, scale_invariant=True, color=PATH_COLOUR
    )
    line.pose.orientation.w = 1.0
    for x, y, z in points.tolist():
        line.points.add(x=x, y=y, z=z)
    return update.SerializeToString()


def removal() -> bytes:
    """Return a serialized SceneUpdate that deletes all entities of its topic."""
    update = SceneUpdate()
    update.deletions.add(type=SceneEntityDeletion.ALL)
    return update.SerializeToString()


def _pose(position: np.ndarray, quat_wxyz: np.ndarray) -> Pose:
    x, y, z = position.tolist()
    w, i, j, k = quat_wxyz.tolist()
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w))
