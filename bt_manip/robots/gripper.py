"""What every kind of gripper promises, and what a robot's description says of one."""

import abc
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.toml_tables import PythonSource, TomlFile, TomlTable

from .errors import GripperError, RobotError
from .grasp_candidates import GraspCandidates

if TYPE_CHECKING:
    from .robot import Robot

DEFAULT_KIND = "two_finger"
"""The kind of a gripper whose description names none."""

COMMON_KEYS = ("kind", "max_force", "model", "mount", "position", "quat_wxyz", "rpy")
"""Keys of ``[gripper]`` that every kind has."""


@dataclass(frozen=True)
class GripperDescription:
    """A gripper: its kind, what every kind has, and what only its kind knows.

    Attributes:
        max_force: Greatest force that it is asked to hold with [N].
        kind: Registered name of the kind of gripper.
        parameters: What the kind asks for, as plain data; `read` hands it over.
        model: Where its MJCF file is; None: it is part of the arm's.
        mount: Name of the arm's site or body that a model of its own is attached to.
        T_mg: Pose of that model in the mount.
        file: The file that the parameters are from, for messages.
    """

    max_force: float
    kind: str = DEFAULT_KIND
    parameters: Mapping[str, Any] = field(default_factory=dict)
    model: str | None = None
    mount: str | None = None
    T_mg: pin.SE3 = field(default_factory=pin.SE3.Identity)
    file: TomlFile | PythonSource | None = field(default=None, compare=False, repr=False)

    def read(self, robot: str) -> TomlTable:
        """Give the parameters key by key; the kind calls ``finish`` to refuse unknown ones.

        Args:
            robot: Name of the robot, for messages.
        """
        source = self.file or PythonSource(f"robot '{robot}'", RobotError)
        table = TomlTable(source, self.parameters, ("gripper",))
        for key in COMMON_KEYS:  # known, to be offered where a key is mistyped
            table.value(key)
        return table


class GraspGenerator(Protocol):
    """Generates the grasp candidates of one object for one gripper.

    Attributes:
        com: The object's centre of mass, in its frame [m].  # (3,)
    """

    com: np.ndarray

    def candidates(self, down: np.ndarray) -> GraspCandidates:
        """List the grasps that do not come from below.

        Args:
            down: Straight down in the object's frame; unit.  # (3,)

        Raises:
            MotionError: When the gripper cannot grip the object, with the reason.
        """


class Gripper(composer.Entity, abc.ABC):
    """A robot's gripper: commands, measurements, and its part in planning.

    A kind of gripper is a subclass and is registered by the hook ``register_grippers``. Its robot
    makes it (``Robot(description, gripper=MyGripper)``), before anything is compiled: ``_build``
    may change the robot's model, as by adding actuators and sensors. From then on it lives by
    composer's hooks. Commands return at once; what they ask for happens in the steps that follow.
    """

    kind: ClassVar[str] = "gripper"

    def _build(self, robot: "Robot") -> None:
        """Prepare to control a robot's gripper; subclasses add what they need.

        Raises:
            RobotError: When the robot's description has no gripper.
        """
        description = robot.description.gripper
        if description is None:
            raise RobotError(f"robot '{robot.description.name}' has no gripper")
        self._mjcf_root = mjcf.RootElement(model=f"{self.kind}_gripper")
        self._robot, self._description = robot, description
        self._ids: tuple[mujoco.MjModel, tuple[int, ...]] | None = None

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """An empty model: what composer attaches."""
        return self._mjcf_root

    @property
    def robot(self) -> "Robot":
        """The robot whose gripper it is."""
        return self._robot

    @property
    def max_force(self) -> float:
        """Greatest force that it is asked to hold with [N]."""
        return self._description.max_force

    def check_force(self, force: float) -> float:
        """Give a force that the gripper can hold with [N].

        Raises:
            GripperError: When it cannot.
        """
        if not 0.0 < force <= self.max_force:
            raise GripperError(
                f"the gripper holds with up to {self.max_force:g} N, not {force:g} N"
            )
        return float(force)

    # Commands

    @abc.abstractmethod
    def open(self) -> None:
        """Let go of what is held, and be ready to grip."""

    @abc.abstractmethod
    def close(self, force: float) -> None:
        """Grip with a force [N].

        Raises:
            GripperError: When the gripper has no such force.
        """

    @abc.abstractmethod
    def stop(self) -> None:
        """Stop where it is; what is held stays held."""

    # Measurements

    @property
    @abc.abstractmethod
    def moving(self) -> bool:
        """Whether a command is still being carried out."""

    @property
    @abc.abstractmethod
    def is_open(self) -> bool:
        """Whether it is ready to grip, and at rest."""

    @property
    @abc.abstractmethod
    def steady(self) -> bool:
        """Whether it holds with the asked force, and has for a while."""

    @property
    @abc.abstractmethod
    def closed_on_nothing(self) -> bool:
        """Whether it has closed without gripping anything."""

    @property
    @abc.abstractmethod
    def is_free(self) -> bool:
        """Whether its contact bodies touch nothing."""

    @property
    @abc.abstractmethod
    def held(self) -> tuple[str, ...]:
        """Names of the entities that are held."""

    @property
    @abc.abstractmethod
    def forces(self) -> tuple[float, ...]:
        """Force on what is held in the last step, one for each place that holds it [N]."""

    @property
    @abc.abstractmethod
    def status(self) -> str:
        """What it is at, in a few words: its forces, or how far it is open."""

    # Geometry

    @property
    @abc.abstractmethod
    def contact_bodies(self) -> Sequence[Any]:
        """Bodies of the robot's model (PyMJCF elements) that may touch what is gripped."""

    @abc.abstractmethod
    def held_root(self) -> int:
        """Give the root body of the free object that moves with the gripper now; 0 for none.

        Asked of the positions and contacts as they are, not of the last step's.
        """

    @abc.abstractmethod
    def set_opening(self, qpos: np.ndarray, share: float = 1.0) -> None:
        """Write the positions of the gripper's joints into positions of the physics.

        Args:
            qpos: All positions, which are changed.
            share: 1 for open, 0 for closed.
        """

    @abc.abstractmethod
    def grasp_generator(
        self,
        name: str,
        solids: Sequence[Any],
        geom_poses: Mapping[int, pin.SE3],
        com: np.ndarray,
        rng: np.random.Generator,
    ) -> GraspGenerator:
        """Return what generates the grasps of an object.

        Args:
            name: Name of the object, for messages.
            solids: Its convex solids (`bt_manip.grippers.Solid`), in its frame.
            geom_poses: Pose of each geom that moves with the tool, in the tool frame, with the
                gripper open.
            com: The object's centre of mass, in its frame [m].  # (3,)
            rng: Random generator, for points on its surface.
        """

    @property
    def contact_body_ids(self) -> tuple[int, ...]:
        """The contact bodies in the compiled model."""
        model = self._robot.mj_model
        if self._ids is None or self._ids[0] is not model:
            names = [body.full_identifier for body in self.contact_bodies]
            self._ids = model, tuple(int(model.body(name).id) for name in names)
        return self._ids[1]

    # State

    @abc.abstractmethod
    def get_state(self) -> dict[str, Any]:
        """Give what is remembered between steps as plain data."""

    @abc.abstractmethod
    def set_state(self, state: Mapping[str, Any]) -> None:
        """Take back what ``get_state`` gave."""
