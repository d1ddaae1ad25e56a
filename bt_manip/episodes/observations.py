"""Observations of an episode: proprioception, objects, contact wrenches and images."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import FrameRenderer, as_object, camera_number, entity_of
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.robots import Gripper, Robot
from bt_manip.runner import Station

IMAGES = ("rgb", "depth", "segmentation")
"""Kinds of images."""

Read = Callable[[], np.ndarray]


class ObservationSpec(NamedTuple):
    """One observation.

    Attributes:
        shape: Shape of its array.
        dtype: NumPy's name of its number type.
        unit: Unit of its numbers; separated by commas where groups of them differ.
    """

    shape: tuple[int, ...]
    dtype: str
    unit: str


class Images(NamedTuple):
    """The images that observations include.

    Attributes:
        kinds: ``"rgb"``, ``"depth"`` and ``"segmentation"``; empty for none.
        cameras: Full names of cameras in the cell.
        width: Of each image [pixels].
        height: Of each image [pixels].
    """

    kinds: Sequence[str] = ()
    cameras: Sequence[str] = ("overview",)
    width: int = 128
    height: int = 128


class Observations:
    """Reads the observations of a station.

    Positions and rotations are in the world, a rotation as the x and y axes of the frame. Wrenches
    are those of the last control step: of the last link on what is mounted on it, in the tool
    frame; on an object, in world axes about its origin. Names, shapes and objects are those of the
    station at construction. The numbers of an object that has left the cell are zero.

    Attributes:
        specs: The observations by name, in a fixed order.
        entities: Names of entities by their numbers in segmentation images; 0 is everything else.
    """

    def __init__(self, station: Station, images: Images | None = None) -> None:
        """List the observations of the present robots and objects.

        Args:
            station: The station.
            images: The images to include; default: none.

        Raises:
            BtManipError: If a kind of images or a camera is not known.
        """
        cell = self._cell = station.cell
        self._images = images or Images()
        self.specs: dict[str, ObservationSpec] = {}
        self._readers: dict[str, Read] = {}
        for name, one in station.robots.items():
            self._add_robot(name if len(station.robots) > 1 else "robot", one.robot)
        for name, entity in cell.objects.items():
            if cell.is_free(name) or as_object(entity).category != "surface":
                self._add_object(name)
        self.entities = ("", *cell.entities)
        self._renderer: FrameRenderer | None = None
        self._add_images()

    def read(self) -> dict[str, np.ndarray]:
        """Return the present observations by name; every array is new."""
        found = {
            name: np.array(read(), dtype=self.specs[name].dtype)
            for name, read in self._readers.items()
        }
        return found | self._rendered() if self._images.kinds else found

    def close(self) -> None:
        """Free what renders the images."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    # Numbers

    def _add(self, name: str, size: int, unit: str, read: Read) -> None:
        self.specs[name] = ObservationSpec((size,), "float32", unit)
        self._readers[name] = read

    def _add_robot(self, label: str, robot: Robot) -> None:
        n = len(robot.description.arm_joints)
        # Each compile sets the robot's readers anew.
        self._add(f"{label}_joint_positions", n, "rad", lambda: robot.read_q())
        self._add(f"{label}_joint_velocities", n, "rad/s", lambda: robot.read_v())
        self._add(f"{label}_tool_position", 3, "m", lambda: robot.tool_pose.translation)
        self._add(f"{label}_tool_rotation", 6, "-", lambda: _rotation(robot.tool_pose))
        self._add(f"{label}_wrist_wrench", 6, "N,N m", lambda: np.hstack(robot.wrist_wrench()))
        if robot.gripper is not None:
            gripper, opening = robot.gripper, _Opening(robot, robot.gripper)
            self._add(f"{label}_gripper_opening", 1, "-", opening)
            self._add(
                f"{label}_gripper_forces", len(gripper.forces), "N",
                lambda: np.array(gripper.forces),
            )  # fmt: skip

    def _add_object(self, name: str) -> None:
        cell = self._cell

        def unless_gone(read: Callable[[], np.ndarray], size: int) -> Read:
            return lambda: read() if name in cell.entities else np.zeros(size)

        def wrench() -> np.ndarray:
            return np.hstack(cell.contacts.wrench(name))

        def positions() -> np.ndarray:
            return cell.data.qpos[_joint_addresses(cell.model, name)]

        self._add(f"{name}_position", 3, "m", unless_gone(lambda: cell.pose(name).translation, 3))
        self._add(f"{name}_rotation", 6, "-", unless_gone(lambda: _rotation(cell.pose(name)), 6))
        if cell.is_free(name):
            self._add(
                f"{name}_velocity", 6, "m/s,rad/s", unless_gone(lambda: cell.velocity(name), 6)
            )
            self._add(f"{name}_contact_wrench", 6, "N,N m", unless_gone(wrench, 6))
        joints = len(_joint_addresses(cell.model, name))
        if joints:
            self._add(f"{name}_joint_positions", joints, "rad or m", unless_gone(positions, joints))

    # Images

    def _add_images(self) -> None:
        kinds, cameras, width, height = self._images
        channels = {"rgb": ((3,), "uint8", "-"), "depth": ((), "float32", "m")}
        for camera in cameras if kinds else ():
            camera_number(self._cell.model, camera)  # raises if there is none
            for kind in kinds:
                if kind not in IMAGES:
                    raise BtManipError(f"no images are called '{kind}'{did_you_mean(kind, IMAGES)}")
                last, dtype, unit = channels.get(kind, ((), "int32", "-"))
                spec = ObservationSpec((height, width, *last), dtype, unit)
                self.specs[f"{camera}_{kind}".replace("/", "_")] = spec

    def _rendered(self) -> dict[str, np.ndarray]:
        """Return the images of the present state."""
        kinds, cameras, width, height = self._images
        model = self._cell.model
        if self._renderer is None or self._renderer.model is not model:
            self.close()
            self._renderer = FrameRenderer(model, width, height)
        renderer, found = self._renderer, {}
        for camera in cameras:
            renderer.show(self._cell.data, camera_number(model, camera))
            for kind in kinds:
                found[f"{camera}_{kind}".replace("/", "_")] = self._image(renderer, kind)
        return found

    def _image(self, renderer: FrameRenderer, kind: str) -> np.ndarray:
        if kind == "rgb":
            return renderer.render().copy()
        if kind == "depth":
            renderer.enable_depth_rendering()
            try:
                return renderer.render().copy()
            finally:
                renderer.disable_depth_rendering()
        renderer.enable_segmentation_rendering()
        try:
            elements = renderer.render()  # number and type of each pixel's element
        finally:
            renderer.disable_segmentation_rendering()
        is_geom = elements[..., 1] == mujoco.mjtObj.mjOBJ_GEOM
        # One more for pixels that show no geom: -1, the last.
        numbers = np.array([*self._geom_numbers(renderer.model), 0], dtype=np.int32)
        return numbers[np.where(is_geom, elements[..., 0], -1)]

    def _geom_numbers(self, model: mujoco.MjModel) -> list[int]:
        """Return the number of the entity of each geom."""
        numbers = {name: i for i, name in enumerate(self.entities)}
        return [numbers.get(entity_of(model.geom(i).name), 0) for i in range(model.ngeom)]


class _Opening:
    """Reads the share by which a gripper is open, from 0 to 1, along its joints' motion."""

    def __init__(self, robot: Robot, gripper: Gripper) -> None:
        self._robot, self._gripper = robot, gripper
        self._model: mujoco.MjModel | None = None

    def __call__(self) -> np.ndarray:
        """Return it."""  # (1,)
        robot, gripper = self._robot, self._gripper
        if self._model is not robot.mj_model:
            self._model = robot.mj_model
            closed, opened = self._model.qpos0.copy(), self._model.qpos0.copy()
            gripper.set_opening(closed, 0.0)
            gripper.set_opening(opened, 1.0)
            self._moving = np.flatnonzero(opened != closed)
            way = (opened - closed)[self._moving]
            self._closed, self._scale = closed[self._moving], way / max(way @ way, 1e-12)
        if not self._moving.size:  # as of a suction cup
            return np.array([0.0 if gripper.gripping else 1.0])
        here = robot.mj_data.qpos[self._moving] - self._closed
        return np.array([here @ self._scale])


def _rotation(T: pin.SE3) -> np.ndarray:
    """Return the x and y axes of a pose: numbers that are continuous (Zhou et al., 2019)."""
    return T.rotation[:, :2].T.ravel()  # (6,)


def _joint_addresses(model: mujoco.MjModel, name: str) -> list[int]:
    """Return the addresses in qpos of the hinges and slides of an entity."""
    single = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
    return [
        int(model.jnt_qposadr[i])
        for i in range(model.njnt)
        if model.jnt_type[i] in single and entity_of(model.joint(i).name) == name
    ]
