"""Interface of grippers, and their part of a robot's description."""

import abc
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, NamedTuple, Protocol

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.cell import BodyNames
from bt_manip.toml_fields import (
    Key,
    KeyField,
    OtherKeys,
    documented,
    entries_of,
    read_fields,
    write_fields,
)
from bt_manip.toml_tables import PythonSource, TomlFile, TomlTable

from .errors import GripperError, RobotError
from .grasp_candidates import GraspCandidates
from .model_address import ModelAddress

if TYPE_CHECKING:
    from .robot import Robot

DEFAULT_KIND = "two_finger"
"""Kind of gripper if the description names none."""

_FORCE = 50.0  # [N] of grippers that are strong enough
_FORCE_PART = 0.8  # of the maximum force of others: a motor at its limit controls no force


@documented
@dataclass(frozen=True)
class GripperDescription:
    """Description of a gripper: its kind, common data, and parameters of the kind.

    The field `file`, not a key, is the file that contains the parameters, for messages.
    """

    kind: Annotated[str, Key("Registered name of the kind of gripper")] = DEFAULT_KIND
    max_force: Annotated[
        float | None,
        Key("Maximum grip force; left out where parameters of the kind imply it", "N", above=0.0),
    ] = None
    model: Annotated[
        str | None,
        Key("Its file of MJCF or URDF; left out if it is part of the arm's", values=ModelAddress()),
    ] = None
    mount: Annotated[
        str | None, Key("The arm's site or body to which a separate model is attached")
    ] = None
    T_mg: Annotated[pin.SE3, Key("Pose of that model in the mount", "m, rad")] = field(
        default_factory=pin.SE3.Identity
    )
    parameters: Annotated[
        Mapping[str, Any],
        Key(
            "Parameters of the kind, as plain data; `read` gives a table",
            values=OtherKeys("keys of the kind"),
        ),
    ] = field(default_factory=dict)
    file: TomlFile | PythonSource | None = field(default=None, compare=False, repr=False)

    def read(self, robot: str) -> TomlTable:
        """Return the parameters as a table; the kind calls ``finish`` to reject unknown keys.

        Args:
            robot: Name of the robot, for messages.
        """
        source = self.file or PythonSource(f"robot '{robot}'", RobotError)
        table = TomlTable(source, self.parameters, ("gripper",))
        for entry in entries_of(type(self)):  # known, to be suggested for mistyped keys
            if not isinstance(entry.values, OtherKeys):
                entry.values.read(table, entry, None)
        return table


class GripperTable:
    """The table of a gripper's description; one with a model of its own needs a mount."""

    type, cls = "a table", GripperDescription

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> GripperDescription | None:
        """Return the description."""
        return self.read_table(table.table(entry.name))

    def read_table(self, table: TomlTable | None) -> GripperDescription | None:
        """Return the description in ``[gripper]``."""
        if table is None:
            return None
        given = read_fields(GripperDescription, table)
        if "model" in given:
            table.require("mount", "a text")
        return GripperDescription(**given, file=table.file)

    def write(
        self, value: GripperDescription, entry: KeyField, folder: Path | None
    ) -> dict[str, Any]:
        """Return the table."""
        return {entry.name: write_fields(value, folder)}


class FoundGripper(NamedTuple):
    """A gripper of some kind found in a model; all names are full ones.

    Attributes:
        parameters: Parameters of its kind.
        max_force: Maximum grip force [N]; None where it follows from the parameters.
        body: Body that carries the gripper.
        T_bt: Pose of the tool in it; z is the approach direction.
        notes: Comments by key, such as ``"gripper.effort"``.
    """

    parameters: dict[str, Any]
    max_force: float | None
    body: str
    T_bt: pin.SE3
    notes: Mapping[str, str] = MappingProxyType({})


class GraspGenerator(Protocol):
    """Generates the grasp candidates of one object for one gripper.

    Attributes:
        com: The object's centre of mass, in its frame [m].  # (3,)
    """

    com: np.ndarray

    def candidates(self, down: np.ndarray) -> GraspCandidates:
        """Return the grasps that do not approach from below.

        Args:
            down: Straight down in the object's frame; unit.  # (3,)

        Raises:
            MotionError: If the gripper cannot grip the object; the message has the reason.
        """


class Gripper(composer.Entity, abc.ABC):
    """A robot's gripper: commands, measurements, and its part in planning.

    A kind of gripper is a subclass and is registered by the hook ``register_grippers``. The robot
    creates it (``Robot(description, gripper=MyGripper)``) before the model is compiled, so
    ``_build`` may change the robot's model, for example by adding actuators and sensors. Composer's
    hooks then run it. Commands return at once and are executed during the following steps.
    """

    kind: ClassVar[str] = "gripper"

    def _build(self, robot: "Robot") -> None:
        """Initialize the control of a robot's gripper; subclasses extend this.

        Raises:
            RobotError: If the robot's description has no gripper.
        """
        description = robot.description.gripper
        if description is None:
            raise RobotError(f"robot '{robot.description.name}' has no gripper")
        self._mjcf_root = mjcf.RootElement(model=f"{self.kind}_gripper")
        self._robot, self._description = robot, description
        self._ids: tuple[mujoco.MjModel, tuple[int, ...]] | None = None
        self._names: tuple[mujoco.MjModel, BodyNames] | None = None

    @classmethod
    def check_parameters(cls, table: TomlTable) -> None:
        """Check the parameters of this kind without a model; by default none are.

        Args:
            table: The table ``[gripper]``.

        Raises:
            RobotError: If keys are missing, wrong or unknown; the message has a line for each.
        """

    @classmethod
    def found_in(cls, model: mujoco.MjModel, arm_joints: Sequence[str]) -> FoundGripper | None:
        """Return a gripper of this kind found in a model, to describe it; by default none.

        Args:
            model: The robot, compiled alone.
            arm_joints: Full names of the arm's joints, from the base to the tool.
        """
        return None

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """An empty model, which composer attaches."""
        return self._mjcf_root

    @property
    def robot(self) -> "Robot":
        """The robot that has this gripper."""
        return self._robot

    @property
    def max_force(self) -> float:
        """Maximum grip force [N].

        Raises:
            RobotError: If the description does not give it and the kind does not override this.
        """
        description = self._description
        if description.max_force is None:
            table = description.read(self._robot.description.name)
            raise table.error("max_force", "is missing: the maximum grip force [N]")
        return description.max_force

    @property
    def default_force(self) -> float:
        """Force to grip with where none is given [N]."""
        return _FORCE if self.max_force >= _FORCE else _FORCE_PART * self.max_force

    def check_force(self, force: float) -> float:
        """Return a grip force after checking it [N].

        Raises:
            GripperError: If the gripper cannot hold with this force.
        """
        if not 0.0 < force <= self.max_force:
            raise GripperError(
                f"the gripper holds with up to {self.max_force:g} N, not {force:g} N"
            )
        return float(force)

    def required_friction(self, weight: float, force: float) -> float:
        """Return the sliding friction with which a grip carries a weight at rest [-].

        Zero if friction does not carry it, the default.

        Args:
            weight: Weight of the object [N].
            force: Grip force [N].

        Raises:
            GripperError: If a grip with this force carries it with no friction.
        """
        return 0.0

    @property
    def max_object_width(self) -> float:
        """Width of the widest object that fits the open gripper [m]; inf where any does."""
        return math.inf

    # Commands

    @abc.abstractmethod
    def open(self) -> None:
        """Release the held object and open, ready to grip."""

    @abc.abstractmethod
    def close(self, force: float) -> None:
        """Grip with a force [N].

        Raises:
            GripperError: If the gripper cannot hold with this force.
        """

    @abc.abstractmethod
    def stop(self) -> None:
        """Stop at the current opening; a held object stays held."""

    # Measurements

    @property
    @abc.abstractmethod
    def moving(self) -> bool:
        """Whether a command is still being executed."""

    @property
    @abc.abstractmethod
    def is_open(self) -> bool:
        """Whether it is open, ready to grip and at rest."""

    @property
    @abc.abstractmethod
    def steady(self) -> bool:
        """Whether it has held with the commanded force for some time."""

    @property
    @abc.abstractmethod
    def closed_on_nothing(self) -> bool:
        """Whether it has closed without gripping anything."""

    @property
    def gripping(self) -> bool:
        """Whether its last command was to grip; a kind that knows overrides this."""
        return self.steady or self.closed_on_nothing

    @property
    @abc.abstractmethod
    def is_free(self) -> bool:
        """Whether it may move away: it touches nothing that moves with it."""

    @property
    @abc.abstractmethod
    def held(self) -> tuple[str, ...]:
        """Names of the held entities."""

    @property
    @abc.abstractmethod
    def forces(self) -> tuple[float, ...]:
        """Force on the held object in the last step, one per gripping surface [N]."""

    @property
    @abc.abstractmethod
    def status(self) -> str:
        """Short description of its state: the forces or the opening."""

    # Geometry

    @property
    @abc.abstractmethod
    def contact_bodies(self) -> Sequence[Any]:
        """Bodies of the robot's model (PyMJCF elements) that may touch a gripped object."""

    @abc.abstractmethod
    def held_root(self) -> int:
        """Return the root body of the free object that moves with the gripper now; 0 for none.

        Computed from the current positions and contacts, not from those of the last step.
        """

    @abc.abstractmethod
    def set_opening(self, qpos: np.ndarray, share: float = 1.0) -> None:
        """Write the gripper's joint positions for an opening into ``qpos``.

        Args:
            qpos: Joint positions of the whole model, changed in place.
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
        """Return a grasp generator for an object.

        Args:
            name: Name of the object, for messages.
            solids: Its convex solids (`bt_manip.grippers.Solid`), in its frame.
            geom_poses: Pose in the tool frame of each geom that moves with the tool, with the
                gripper open.
            com: The object's centre of mass, in its frame [m].  # (3,)
            rng: Random generator for points on its surface.
        """

    @property
    def contact_body_ids(self) -> tuple[int, ...]:
        """Ids of the contact bodies in the compiled model."""
        model = self._robot.mj_model
        if self._ids is None or self._ids[0] is not model:
            names = [body.full_identifier for body in self.contact_bodies]
            self._ids = model, tuple(int(model.body(name).id) for name in names)
        return self._ids[1]

    @property
    def body_names(self) -> BodyNames:
        """Names ``entity/body`` of the bodies and geoms of the compiled model."""
        model = self._robot.mj_model
        if self._names is None or self._names[0] is not model:
            self._names = model, BodyNames(model)
        return self._names[1]

    # State

    @abc.abstractmethod
    def get_state(self) -> dict[str, Any]:
        """Return the state kept between steps, as plain data."""

    @abc.abstractmethod
    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state returned by ``get_state``."""
