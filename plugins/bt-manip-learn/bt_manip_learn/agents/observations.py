"""Observations of an episode: proprioception, objects, contact wrenches and images."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, FrameRenderer, as_object, camera_number, entity_of
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.robots import Gripper, Robot
from bt_manip.runner import CommandedRobot

ROBOT = "robot"
"""Group of observations that a robot can measure: its own state, and camera images."""

SIMULATOR = "simulator"
"""Group of observations that only a simulator knows: objects, and segmentation images."""

IMAGES = ("rgb", "depth", "segmentation")
"""Kinds of images."""

Read = Callable[[], Sequence[Any]]
Specs = Mapping[str, tuple[int, str]]
"""Size and unit of observations by name."""


class ObservationSpec(NamedTuple):
    """One observation.

    Attributes:
        shape: Shape of its array.
        dtype: NumPy name of its data type.
        unit: Unit of its values; several units are separated by commas.
        group: `ROBOT` or `SIMULATOR`.
    """

    shape: tuple[int, ...]
    dtype: str
    unit: str
    group: str = ROBOT


class Images(NamedTuple):
    """Images to observe.

    Attributes:
        kinds: Any of ``"rgb"``, ``"depth"`` and ``"segmentation"``; empty for none.
        cameras: Full names of cameras in the cell.
        width: Width of each image [pixels].
        height: Height of each image [pixels].
    """

    kinds: Sequence[str] = ("rgb",)
    cameras: Sequence[str] = ("overview",)
    width: int = 128
    height: int = 128


NO_IMAGES = Images((), ())


class Observations:
    """Reads the observations of robots and their cell.

    Positions and rotations are in the world frame, a rotation as the x and y axes of the frame.
    Wrenches are from the last control step: of the last link on the mounted gripper, in the tool
    frame; of all contacts on an object, in world axes about its origin. Names, shapes and objects
    are those of the cell at construction. The values of a removed object are zero.

    Args:
        cell: The cell.
        robots: The observed robots, by name.
        images: Images to observe; default: none.

    Attributes:
        specs: The observations by name, in a fixed order.
        entities: Names of entities by their ids in segmentation images; 0: everything else.

    Raises:
        BtManipError: If a kind of images or a camera is unknown.
    """

    def __init__(
        self, cell: Cell, robots: Mapping[str, CommandedRobot], images: Images | None = None
    ) -> None:
        self._cell = cell
        self._wanted = images or NO_IMAGES
        self.specs: dict[str, ObservationSpec] = {}
        self._readers: list[Read] = []
        for name, one in robots.items():
            self._add_robot(name if len(robots) > 1 else "robot", one)
        for name, entity in cell.objects.items():
            if cell.is_free(name) or as_object(entity).category != "surface":
                self._add_object(name)
        self.entities = ("", *cell.entities)
        self._renderer: FrameRenderer | None = None
        self._add_images()

    def read(self) -> dict[str, np.ndarray]:
        """Return the present observations by name, in new arrays."""
        numbers = [np.array(one, np.float32) for read in self._readers for one in read()]
        found = dict(zip(self.specs, numbers, strict=False))  # images follow
        return found | self.images() if self._wanted.kinds else found

    def close(self) -> None:
        """Free the renderers of the images."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None

    # Numbers

    def _add(self, owner: str, group: str, specs: Specs, read: Read) -> None:
        """Add observations of a robot or object, and a function to read all of them."""
        for name, (size, unit) in specs.items():
            self.specs[f"{owner}_{name}"] = ObservationSpec((size,), "float32", unit, group)
        self._readers.append(read)

    def _add_robot(self, label: str, one: CommandedRobot) -> None:
        robot, gripper = one.robot, one.gripper
        n = len(robot.description.arm_joints)
        specs = {
            "joint_positions": (n, "rad"), "joint_velocities": (n, "rad/s"),
            "tool_position": (3, "m"), "tool_rotation": (6, "-"), "wrist_wrench": (6, "N,N m"),
        }  # fmt: skip
        if gripper is not None:
            specs |= {"gripper_opening": (1, "-"), "gripper_forces": (len(gripper.forces), "N")}
            opening = _Opening(robot, gripper)

        def read() -> Sequence[Any]:
            q = robot.read_q()
            T = one.arm.model.pose(q)
            wrench = np.concatenate(robot.wrist_wrench(T))
            found = [q, robot.read_v(), T.translation, _rotation(T), wrench]
            return found if gripper is None else [*found, opening.read(), gripper.forces]

        self._add(label, ROBOT, specs, read)

    def _add_object(self, name: str) -> None:
        cell = self._cell
        specs = {"position": (3, "m"), "rotation": (6, "-")}
        if free := cell.is_free(name):
            specs |= {"velocity": (6, "m/s,rad/s"), "contact_wrench": (6, "N,N m")}
        model, addresses = cell.model, _joint_addresses(cell.model, name)
        if joints := len(addresses):
            specs["joint_positions"] = (joints, "rad or m")
        nothing = [np.zeros(size) for size, _ in specs.values()]

        def read() -> Sequence[Any]:
            nonlocal model, addresses
            if name not in cell.entities:
                return nothing
            T = cell.pose(name)
            found = [T.translation, _rotation(T)]
            if free:
                found += [cell.velocity(name), np.concatenate(cell.contacts.wrench(name))]
            if joints:
                if model is not cell.model:
                    model, addresses = cell.model, _joint_addresses(cell.model, name)
                found.append(cell.data.qpos[addresses])
            return found

        self._add(name, SIMULATOR, specs, read)

    # Images

    def _add_images(self) -> None:
        kinds, cameras, width, height = self._wanted
        channels = {"rgb": ((3,), "uint8", "-"), "depth": ((), "float32", "m")}
        for camera in cameras:
            camera_number(self._cell.model, camera)  # raises if there is none
            for kind in kinds:
                if kind not in IMAGES:
                    raise BtManipError(f"no images are called '{kind}'{did_you_mean(kind, IMAGES)}")
                last, dtype, unit = channels.get(kind, ((), "int32", "-"))
                group = SIMULATOR if kind == "segmentation" else ROBOT
                spec = ObservationSpec((height, width, *last), dtype, unit, group)
                self.specs[_image_name(camera, kind)] = spec

    def images(self) -> dict[str, np.ndarray]:
        """Return the images of the present state, by name."""
        kinds, cameras, width, height = self._wanted
        model = self._cell.model
        if self._renderer is None or self._renderer.model is not model:
            self.close()
            # Without shadows and multisampling, software renders 128 x 128 pixels 29 times faster.
            self._renderer = FrameRenderer(model, width, height, shadow_size=0, samples=0)
            numbers = {name: i for i, name in enumerate(self.entities)}
            owners = [entity_of(model.geom(i).name) for i in range(model.ngeom)]
            # The last entry, index -1, is for pixels that show no geom.
            self._geom_numbers = np.array([*(numbers.get(one, 0) for one in owners), 0], np.int32)
        renderer, found = self._renderer, {}
        for camera in cameras:
            renderer.show(self._cell.data, camera_number(model, camera))
            for kind in kinds:
                found[_image_name(camera, kind)] = self._image(renderer, kind)
        return found

    def _image(self, renderer: FrameRenderer, kind: str) -> np.ndarray:
        if kind == "rgb":
            return renderer.render().copy()
        if kind == "depth":
            return renderer.depth().copy()
        elements = renderer.elements()
        is_geom = elements[..., 1] == mujoco.mjtObj.mjOBJ_GEOM
        return self._geom_numbers[np.where(is_geom, elements[..., 0], -1)]


class _Opening:
    """Reads the opening of a gripper, from 0 (closed) to 1, along the motion of its joints."""

    def __init__(self, robot: Robot, gripper: Gripper) -> None:
        self._robot, self._gripper = robot, gripper
        self._model: mujoco.MjModel | None = None

    def read(self) -> list[float]:
        """Return the opening as a list of one number."""
        robot, gripper = self._robot, self._gripper
        if self._model is not robot.mj_model:
            self._model = robot.mj_model
            closed, opened = self._model.qpos0.copy(), self._model.qpos0.copy()
            gripper.set_opening(closed, 0.0)
            gripper.set_opening(opened, 1.0)
            self._moving = np.flatnonzero(opened != closed)
            way = (opened - closed)[self._moving]
            self._closed, self._scale = closed[self._moving], way / (way @ way)
        if not self._moving.size:  # e.g. a suction cup
            return [0.0 if gripper.gripping else 1.0]
        here = robot.mj_data.qpos[self._moving] - self._closed
        return [float(here @ self._scale)]


def _image_name(camera: str, kind: str) -> str:
    return f"{camera}_{kind}".replace("/", "_")


def _rotation(T: pin.SE3) -> np.ndarray:
    """Return the x and y axes of a pose, a continuous representation (Zhou et al., 2019)."""
    return T.rotation[:, :2].T.ravel()  # (6,)


def _joint_addresses(model: mujoco.MjModel, name: str) -> list[int]:
    """Return the ``qpos`` addresses of the hinges and slides of an entity."""
    single = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    return [
        int(model.jnt_qposadr[i])
        for i in range(model.njnt)
        if int(model.jnt_type[i]) in single and entity_of(model.joint(i).name) == name
    ]
