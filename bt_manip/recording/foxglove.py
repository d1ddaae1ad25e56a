"""The scene of a cell as messages of Foxglove's schemas: geometry, frames and log lines."""

from collections.abc import Sequence

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

from bt_manip.cell import entity_of
from bt_manip.recording.protobuf import NumberTemplate

WORLD_FRAME = "world"
"""Name of the frame of MuJoCo's world body."""

PLANE_SIZE = 10.0
"""Edge length of the square that stands for an infinite plane [m]."""

VISIBLE_GROUPS = 3
"""Geoms of the groups below this number are visible, as in MuJoCo's viewers."""

DEFAULT_COLOUR = (0.5, 0.5, 0.5, 1.0)
"""MuJoCo's colour of a geom that has none: its material's colour is used instead."""

_Geom = mujoco.mjtGeom


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
        name: Where it comes from.
        message: The line.
    """
    log = Log(timestamp=timestamp_of(nanoseconds), name=name, message=message)
    log.level = Log.Level.Value(level)
    return log.SerializeToString()


class SceneMessages:
    """Frames and geometry of one compiled model.

    Attributes:
        entities: Names of the entities, ``"world"`` for what belongs to none, in order.
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Read the names and the movable bodies of a model.

        Args:
            model: The compiled model.
            data: Its data.
        """
        self._model, self._data = model, data
        self._frames = [WORLD_FRAME, *(_frame_name(model, i) for i in range(1, model.nbody))]
        names = [entity_of(name) for name in self._frames]
        self.entities = list(dict.fromkeys(names))
        of_body = np.array([self.entities.index(name) for name in names])
        self._of_geom = np.where(model.geom_group < VISIBLE_GROUPS, of_body[model.geom_bodyid], -1)
        bodies = np.arange(1, model.nbody)
        movable = bodies[model.body_weldid[bodies] != 0]
        # One range, which is read faster than single rows; fixed bodies in it do no harm.
        first, last = (movable[0], movable[-1] + 1) if len(movable) else (1, 1)
        self._movable = slice(int(first), int(last))
        self._fixed = np.setdiff1d(bodies, movable)
        self._xpos, self._xquat = data.xpos[self._movable], data.xquat[self._movable]
        self._templates: dict[int, tuple[NumberTemplate, bytes]] = {}  # by length of the time stamp

    def fixed_frames(self, nanoseconds: int) -> bytes:
        """Return a serialized FrameTransforms of the bodies that cannot move."""
        return self._transforms(self._fixed, nanoseconds).SerializeToString()

    def copy_poses(self) -> bytes:
        """Return the present poses of the other bodies, for `movable_frames`."""
        return self._xpos.tobytes() + self._xquat.tobytes()

    def movable_frames(self, nanoseconds: int, poses: bytes) -> bytes:
        """Return a serialized FrameTransforms of the other bodies, in about 5 us."""
        time = timestamp_of(nanoseconds).SerializeToString()
        found = self._templates.get(len(time))
        if found is None:  # the length of a time stamp on the wire depends on its value

            def build(numbers: Sequence[float]) -> FrameTransforms:
                bodies = np.arange(self._movable.start, self._movable.stop)
                message = self._transforms(bodies, nanoseconds)
                positions = np.reshape(numbers[: 3 * len(bodies)], (-1, 3)).tolist()
                rotations = np.reshape(numbers[3 * len(bodies) :], (-1, 4)).tolist()
                for transform, (x, y, z), (w, i, j, k) in zip(
                    message.transforms, positions, rotations, strict=True
                ):
                    transform.translation.CopyFrom(Vector3(x=x, y=y, z=z))
                    transform.rotation.CopyFrom(Quaternion(x=i, y=j, z=k, w=w))
                return message

            template = NumberTemplate(build, 7 * len(self._xpos))
            found = self._templates[len(time)] = template, time
        template, time_then = found
        message = template.serialize(poses)
        return message.replace(time_then, time) if time else message

    def colours(self, entity: str) -> bytes:
        """Return bytes that change when an entity gets other colours."""
        geoms = self._geoms(entity)
        return self._model.geom_rgba[geoms].tobytes() + self._model.geom_matid[geoms].tobytes()

    def geometry(self, entity: str, nanoseconds: int) -> bytes:
        """Return a serialized SceneUpdate with the visible geoms of an entity."""
        update = SceneUpdate()
        bodies: dict[int, SceneEntity] = {}
        for geom in self._geoms(entity).tolist():
            body = int(self._model.geom_bodyid[geom])
            if body not in bodies:
                frame = self._frames[body]
                bodies[body] = update.entities.add(
                    timestamp=timestamp_of(nanoseconds), frame_id=frame, id=frame, frame_locked=True
                )
            self._add_geom(bodies[body], geom)
        return update.SerializeToString()

    def _geoms(self, entity: str) -> np.ndarray:
        """Return the visible geoms of an entity."""
        return np.flatnonzero(self._of_geom == self.entities.index(entity))

    def _transforms(self, bodies: np.ndarray, nanoseconds: int) -> FrameTransforms:
        message = FrameTransforms()
        for body in bodies.tolist():
            pose = _pose(self._data.xpos[body], self._data.xquat[body])
            message.transforms.add(
                timestamp=timestamp_of(nanoseconds),
                parent_frame_id=WORLD_FRAME,
                child_frame_id=self._frames[body],
                translation=pose.position,
                rotation=pose.orientation,
            )
        return message

    def _add_geom(self, entity: SceneEntity, geom: int) -> None:
        model = self._model
        pose = _pose(model.geom_pos[geom], model.geom_quat[geom])
        colour = Color(**dict(zip("rgba", self._colour(geom), strict=True)))
        x, y, z = model.geom_size[geom].tolist()
        kind = _Geom(int(model.geom_type[geom]))
        if kind == _Geom.mjGEOM_MESH:
            self._add_mesh(entity, int(model.geom_dataid[geom]), pose, colour)
        elif kind == _Geom.mjGEOM_BOX:
            entity.cubes.add(pose=pose, size=Vector3(x=2 * x, y=2 * y, z=2 * z), color=colour)
        elif kind == _Geom.mjGEOM_PLANE:
            size = Vector3(x=2 * x or PLANE_SIZE, y=2 * y or PLANE_SIZE, z=1e-4)
            entity.cubes.add(pose=pose, size=size, color=colour)
        elif kind == _Geom.mjGEOM_SPHERE:
            entity.spheres.add(pose=pose, size=Vector3(x=2 * x, y=2 * x, z=2 * x), color=colour)
        elif kind == _Geom.mjGEOM_ELLIPSOID:
            entity.spheres.add(pose=pose, size=Vector3(x=2 * x, y=2 * y, z=2 * z), color=colour)
        elif kind in (_Geom.mjGEOM_CYLINDER, _Geom.mjGEOM_CAPSULE):
            size = Vector3(x=2 * x, y=2 * x, z=2 * y)
            entity.cylinders.add(
                pose=pose, size=size, bottom_scale=1.0, top_scale=1.0, color=colour
            )
            if kind == _Geom.mjGEOM_CAPSULE:
                axis = np.zeros(9)
                mujoco.mju_quat2Mat(axis, model.geom_quat[geom])
                for sign in (-y, y):
                    end = _pose(model.geom_pos[geom] + sign * axis[2::3], model.geom_quat[geom])
                    ball = Vector3(x=2 * x, y=2 * x, z=2 * x)
                    entity.spheres.add(pose=end, size=ball, color=colour)

    def _add_mesh(self, entity: SceneEntity, mesh: int, pose: Pose, colour: Color) -> None:
        model = self._model
        first, count = model.mesh_vertadr[mesh], model.mesh_vertnum[mesh]
        points = serialized_points(model.mesh_vert[first : first + count])
        first, count = model.mesh_faceadr[mesh], model.mesh_facenum[mesh]
        indices = model.mesh_face[first : first + count].ravel().tolist()
        triangles = entity.triangles.add(pose=pose, indices=indices, color=colour)
        triangles.MergeFromString(points)

    def _colour(self, geom: int) -> tuple[float, ...]:
        model = self._model
        colour = tuple(model.geom_rgba[geom].tolist())
        material = int(model.geom_matid[geom])
        if material >= 0 and colour == DEFAULT_COLOUR:
            colour = tuple(model.mat_rgba[material].tolist())
        return colour


def serialized_points(points: np.ndarray) -> bytes:
    """Return a serialized TriangleListPrimitive with some points and nothing else.

    Args:
        points: The points [m].  # (n, 3)
    """
    marks = np.array([1.5, 2.5, 3.5])
    x, y, z = marks.tolist()
    one = TriangleListPrimitive(points=[Point3(x=x, y=y, z=z)]).SerializeToString()
    starts = [one.find(mark.tobytes()) for mark in marks]
    data = np.tile(np.frombuffer(one, dtype=np.uint8), (len(points), 1))
    numbers = np.ascontiguousarray(points, dtype="<f8").view(np.uint8)
    data[:, (np.array(starts)[:, None] + np.arange(8)).ravel()] = numbers
    return data.tobytes()


def removal() -> bytes:
    """Return a serialized SceneUpdate that deletes all that its topic has shown."""
    update = SceneUpdate()
    update.deletions.add(type=SceneEntityDeletion.ALL)
    return update.SerializeToString()


def _pose(position: np.ndarray, quat_wxyz: np.ndarray) -> Pose:
    x, y, z = position.tolist()
    w, i, j, k = quat_wxyz.tolist()
    return Pose(position=Vector3(x=x, y=y, z=z), orientation=Quaternion(x=i, y=j, z=k, w=w))


def _frame_name(model: mujoco.MjModel, body: int) -> str:
    name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body) or f"body{body}"
    return name.rstrip("/")
