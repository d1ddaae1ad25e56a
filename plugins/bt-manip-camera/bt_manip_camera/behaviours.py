"""Behaviours that look: estimated poses, and what was seen and when."""

import contextlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.behaviours import (
    CellBehaviour,
    CellCondition,
    MotionBehaviour,
    ObjectInput,
    pose_output,
    poses_output,
)
from bt_manip.bt import Input, Output, Status, Traits
from bt_manip.cell import CellError, looking_at
from bt_manip.exceptions import MotionError, PortError, did_you_mean
from bt_manip.runner import CommandedRobot
from bt_manip.scenes import ExpectedObjects
from bt_manip.spatial import pose, quat_wxyz

from .camera import DepthCamera, depth_cameras
from .detections import Detections
from .estimation import Estimate, estimate_of
from .frame import Frame
from .perception import Perception
from .renderer import check_opengl
from .seen import SeenPoses
from .segmentation import find_clusters
from .tags import detect_tags, tag_detector

ELEVATIONS = (70.0, 90.0, 55.0, 80.0, 45.0)
"""Directions from which `LookAt` looks, above the horizontal, the preferred one first [degrees]."""

SETTLING = 1.0
"""Time for which frames are not used that were taken while the camera moved [s]."""

NO_FRAMES = "a real robot needs frames of a real camera: --camera NAME=[HOST:]PORT"


class LookingBehaviour(CellBehaviour):
    """A behaviour that takes a frame of a camera: the next one, which arrives later.

    Subclasses implement ``look`` and ``arrived``.
    """

    traits = Traits()
    camera = Input(
        str, default="", doc="Name of a depth_camera of the scene; by default the only one."
    )
    on = ObjectInput(str, default="table", doc="Name of the support.")

    memory = (*CellBehaviour.memory, "_exposure", "_result")

    _exposure = 0.0  # [s] time at which the frame begins
    _result: Any = None  # of `look`, as plain data

    def setup(self, **infrastructure: Any) -> None:
        """Store the cameras, and check that they can render.

        Raises:
            CellError: If there is no such camera, or no OpenGL backend works, or a real robot has
                no camera with a `DepthCamera.source`.
        """
        super().setup(**infrastructure)
        self._robots: Mapping[str, CommandedRobot] = infrastructure["robots"]
        self._rng: np.random.Generator = infrastructure["rng"]
        poses: ExpectedObjects | None = infrastructure.get("poses")
        self.perception = Perception(self.cell, poses, self._robots, infrastructure["models"])
        self._cameras = depth_cameras(infrastructure["sensors"])
        self._real = any(one.arm.connection is not None for one in self._robots.values())
        sources = [one.source for one in self._cameras.values()]
        if self._real and not any(sources):
            raise CellError(NO_FRAMES)
        if not (self._real or all(sources)):
            check_opengl()
        with contextlib.suppress(PortError):  # the entry is not written yet
            self.chosen_camera()

    def chosen_camera(self) -> tuple[str, DepthCamera]:
        """Return the name of the camera and the camera.

        Raises:
            CellError: If there is none, or several and none is named; if it is simulated, but the
                robot is real.
        """
        name, camera = chosen_camera(self.camera, self._cameras)
        if self._real and camera.source is None:
            raise CellError(f"camera '{name}': {NO_FRAMES}")
        return name, camera

    @property
    def surface(self) -> float:
        """Height of the support's surface in the world [m]."""
        return self.cell.surface_height(self.on)

    def start(self) -> None:
        """Wait for the next frame."""
        self._wait_for_frame(self.cell.time)

    def _wait_for_frame(self, earliest: float) -> None:
        """Wait for the first frame that begins at or after a time [s]."""
        self._result, (_, camera) = None, self.chosen_camera()
        self._exposure = camera.next_exposure(earliest)
        camera.request(self._robots)

    def update(self) -> Status:
        """Take the frame when it begins, and use it when it has arrived."""
        now, (_, camera) = self.cell.time + 1e-9, self.chosen_camera()
        self.feedback_message = "waiting for a frame"
        if camera.waiting or now < self._exposure:
            return Status.RUNNING
        if self._result is None:
            if camera.moved(self._robots) and self.elapsed < SETTLING:
                camera.request(self._robots)
                return Status.RUNNING
            self._result = self.look()
        if camera.source is None and now < self._exposure + camera.delay:
            return Status.RUNNING
        return self.arrived(self._result)

    def frame(self) -> Frame:
        """Take a frame."""
        return self.chosen_camera()[1].expose(self._rng, self._robots)

    def show(self, detections: Detections) -> None:
        """Let pages and recordings show what was detected in the frame."""
        self.chosen_camera()[1].detections = detections

    def sighting(self, names: Sequence[str]) -> list[Any]:
        """Take a frame; return why objects are not seen, which are gone, and all estimates.

        Without names, the first are the reasons why objects are refused. All is plain data.
        """
        seen = self.perception.see(self.frame(), self.surface, names)
        self.show(seen.detections)
        missing = [seen.missing[name] for name in names if name in seen.missing]
        if not names:
            missing = [*dict.fromkeys(seen.missing.values())]
        return [missing, sorted(seen.gone), *(one.plain() for one in seen.found.values())]

    def believe(self, result: list[Any]) -> dict[str, Estimate]:
        """Let the objects of `sighting` be where they were seen; return the estimates by name."""
        camera, _ = self.chosen_camera()
        self.perception.lose(result[1])
        found = {plain[0]: estimate_of(plain) for plain in result[2:]}
        for one in found.values():
            self.perception.believe(one, camera)
        return found

    def look(self) -> Any:
        """Take a frame; return what was seen, as plain data."""
        raise NotImplementedError

    def arrived(self, result: Any) -> Status:
        """Use what `look` returned."""
        raise NotImplementedError

    def again(self, reason: str) -> Status:
        """Take the next frame, for a reason."""
        self.feedback_message = reason
        later = self._exposure + 0.5 / self.chosen_camera()[1].rate  # not the same frame again
        self._wait_for_frame(max(self.cell.time, later))
        return Status.RUNNING


class SegmentTable(LookingBehaviour):
    """Find what stands on a support: one pose for each thing, in the order of x."""

    number = Output(int, doc="Number of things.")
    poses = poses_output(
        "Poses of their tops, with x along the long side: each x;y;z;qw;qx;qy;qz [m]."
    )

    def look(self) -> list[list[float]]:
        """Return the poses of the tops of what is not cut by the border."""
        frame, found = self.frame(), []
        clusters = find_clusters(frame, self.surface)
        self.show(Detections(frame, clusters))
        for cluster in clusters:
            if not cluster.at_border:
                top = cluster.rectangle
                turn = (np.cos(top.yaw / 2.0), 0.0, 0.0, np.sin(top.yaw / 2.0))
                found.append([*map(float, top.centre), cluster.surface + cluster.height, *turn])
        return found

    def arrived(self, result: list[list[float]]) -> Status:
        """Write the poses."""
        self.number = len(result)
        self.poses = [pose(one[:3], one[3:]) for one in result]
        self.feedback_message = f"{len(result)} things on '{self.on}'"
        return Status.SUCCESS


class EstimatePose(LookingBehaviour):
    """Estimate the pose of a box or a cylinder of known size on a support.

    With seen poses (``--poses seen``) the object is then where it was seen in what the tree knows,
    and so are all other expected objects that the frame shows; those that were not known appear
    there. It fails with what was seen instead. A thing that can be two of the expected objects, or
    two things that can be the object, are refused.
    """

    object = ObjectInput(str, doc="Name of the object.")
    pose = pose_output("Pose of its origin in the world, x;y;z;qw;qx;qy;qz [m].")
    position_error = Output(float, doc="Estimated standard deviation of its position [m].")

    @property
    def adds_objects(self) -> Sequence[str]:  # type: ignore[override]
        """The object that is expected."""
        with contextlib.suppress(PortError):  # the entry is not written yet
            return [self.object]
        return ["*"]

    def look(self) -> list[Any]:
        """Return all estimates, and why there is none of the object."""
        return self.sighting([self.object])

    def arrived(self, result: list[Any]) -> Status:
        """Let all that was seen be there, and write the pose of the object, or fail."""
        found = self.believe(result)
        if self.object not in found:
            return self.fail(result[0][0])
        one = found[self.object]
        self.pose, self.position_error = one.T_wo, one.position_error
        x, y = one.T_wo.translation[:2]
        error = 1e3 * one.position_error
        self.feedback_message = f"'{one.name}' at ({x:.3f}, {y:.3f}) m, within {error:.1f} mm"
        return Status.SUCCESS


class WaitUntilSeen(EstimatePose):
    """Look at each frame until an object is seen; its pose is then as of `EstimatePose`."""

    timeout = Input(
        float, default=1.0, doc="Simulated time after which it fails [s].", at_least=0.0
    )

    def arrived(self, result: list[Any]) -> Status:
        """Take the next frame if it was not seen."""
        if result[0] and self.elapsed < self.timeout:
            return self.again(result[0][0])
        return super().arrived(result)


class SeeObjects(LookingBehaviour):
    """Look until all objects of a list are seen, and renew the poses of all others that are.

    With seen poses (``--poses seen``) each object is then where it was seen, as of `EstimatePose`;
    without names it takes one frame, and fails if something there can be several objects. Objects
    that look alike are numbered by position when all of them are seen for the first time, and keep
    their names where they are seen again.
    """

    objects = ObjectInput(
        list[str], default=[], doc="Names, patterns or kinds (kind:cube) of the objects."
    )
    timeout = WaitUntilSeen.timeout
    seen = Output(list[str], doc="Names of the objects that were seen in the last frame.")

    adds_objects = ("*",)

    def look(self) -> list[Any]:
        """Return all estimates, and why some are missing."""
        return self.sighting(self.objects)

    def arrived(self, result: list[Any]) -> Status:
        """Let all that was seen be there; take the next frame if some are missing."""
        found = self.believe(result)
        self.seen = list(found)
        missing = result[0]
        if not missing:
            self.feedback_message = f"seen: {', '.join(found) or 'nothing that is expected'}"
            return Status.SUCCESS
        if self.elapsed < self.timeout:
            return self.again(missing[0])
        return self.fail("; ".join(missing))


class DetectTags(LookingBehaviour):
    """Detect AprilTags of the family 36h11 (extra ``tags``): one pose for each."""

    size = Input(
        float, default=0.032, doc="Length of the sides of their black squares [m].", above=0.0
    )
    wanted = Input(list[int], default=[], doc="Numbers that must be seen; empty: any, also none.")
    height = Input(
        float, default=np.nan,
        doc="Height of flat tags in the world, for more accurate positions; nan: unknown [m].",
    )  # fmt: skip
    numbers = Output(list[int], doc="Numbers of the tags in ascending order.")
    poses = poses_output(
        "Their poses: x to the right, z out of the picture: x;y;z;qw;qx;qy;qz [m]."
    )

    def setup(self, **infrastructure: Any) -> None:
        """Store the cameras, and check that tags can be detected.

        Raises:
            BtManipError: If ``pupil-apriltags`` is not installed.
        """
        super().setup(**infrastructure)
        tag_detector()

    def look(self) -> list[list[float]]:
        """Return number and pose of each tag."""
        height = None if np.isnan(self.height) else self.height
        frame = self.frame()
        seen = detect_tags(frame, self.size, height)
        self.show(Detections(frame, tags=seen))
        return [
            [one.number, *one.T_wt.translation.tolist(), *quat_wxyz(one.T_wt).tolist()]
            for one in seen
        ]

    def arrived(self, result: list[list[float]]) -> Status:
        """Write the poses, or fail with the numbers that were seen instead."""
        numbers = [int(one[0]) for one in result]
        self.numbers, self.poses = numbers, [pose(one[1:4], one[4:]) for one in result]
        seen = ", ".join(map(str, numbers)) or "none"
        missing = [number for number in self.wanted if number not in numbers]
        if missing:
            return self.fail(f"tag {', '.join(map(str, missing))} is not seen; seen: {seen}")
        self.feedback_message = f"tags: {seen}"
        return Status.SUCCESS


class IsSeen(CellCondition):
    """Check that an object was seen, not long ago and well enough to be grasped."""

    object = ObjectInput(str, doc="Name of the object.")
    max_age = Input(
        float, default=1e6, doc="Largest time since the frame it was seen in [s].", at_least=0.0
    )
    max_error = Input(
        float, default=5e-3, doc="Largest standard deviation of its position [m].", at_least=0.0
    )

    def setup(self, **infrastructure: Any) -> None:
        """Store what was seen."""
        super().setup(**infrastructure)
        self._poses: ExpectedObjects | None = infrastructure.get("poses")

    def why_not(self) -> str:
        """Return why it is not."""
        source, name = None if self._poses is None else self._poses.source, self.object
        if not isinstance(source, SeenPoses):
            return "nothing is seen in this run: it needs --poses seen"
        found = source.seen.get(name)
        if found is None:
            return f"'{name}' was not seen"
        age = self.cell.time - found.time
        if age > self.max_age:
            return f"'{name}' was seen {age:.1f} s ago"
        if found.position_error > self.max_error:
            return f"'{name}' is known to {1e3 * found.position_error:.1f} mm only"
        return ""


class LookAt(MotionBehaviour):
    """Move the arm so that the camera on its tool looks at an object or a point."""

    camera = LookingBehaviour.camera
    object = ObjectInput(str, default="", doc="Name of an object that is known; empty: the point.")
    point = Input(list[float], default=[0.3, 0.0, 1.015], doc="The point in the world: x;y;z [m].")
    distance = Input(float, default=0.5, doc="Distance of the camera from it [m].", above=0.0)

    def setup(self, **infrastructure: Any) -> None:
        """Store the cameras.

        Raises:
            CellError: If there is no such camera, or it is not on a robot.
        """
        super().setup(**infrastructure)
        self._cameras = depth_cameras(infrastructure["sensors"])
        with contextlib.suppress(PortError):  # the entry is not written yet
            self._on_tool()

    def _on_tool(self) -> pin.SE3:
        """Return the pose of the camera in the frame of the tool."""
        name, camera = chosen_camera(self.camera, self._cameras)
        if not camera.mount:
            raise CellError(f"camera '{name}' is on no robot that could move it")
        return self.cell.pose(name)

    def start(self) -> None:
        """Move to the first pose that the arm reaches, from the nearest directions above."""
        target = np.asarray(self.point, dtype=float)
        if self.object:
            target = self.cell.pose(self.object).translation
        T_ct = self._on_tool().inverse()
        away = (self.T_wt * T_ct.inverse()).translation - target
        ahead = np.arctan2(away[1], away[0])
        failed = []
        for elevation in np.radians(ELEVATIONS):
            poses = []
            for turn in np.radians((0.0, 45.0, -45.0, 90.0, -90.0, 135.0, -135.0, 180.0)):
                flat = np.cos(elevation) * np.array([np.cos(ahead + turn), np.sin(ahead + turn)])
                eye = target + self.distance * np.append(flat, np.sin(elevation))
                T_wc = looking_at(eye, target)
                poses += [
                    T_wc * pin.SE3(pin.utils.rotate("z", roll), np.zeros(3)) * T_ct
                    for roll in np.radians((0.0, 90.0, 180.0, 270.0))
                ]
            try:
                return self.arm.move_to_pose(poses)
            except MotionError as error:
                failed.append(error)
        raise failed[-1]


def chosen_camera(name: str, cameras: Mapping[str, DepthCamera]) -> tuple[str, DepthCamera]:
    """Return a camera by name, or the only one.

    Raises:
        CellError: If there is none, or several and none is named.
    """
    if not cameras:
        raise CellError("the scene has no depth_camera")
    if not name and len(cameras) > 1:
        raise CellError(f"which camera? The scene has {', '.join(cameras)}")
    name = name or next(iter(cameras))
    if name not in cameras:
        raise CellError(f"the scene has no depth_camera '{name}'{did_you_mean(name, cameras)}")
    return name, cameras[name]
