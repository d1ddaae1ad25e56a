"""Interface of grippers."""

import abc
import math
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import composer, mjcf

from bt_manip.cell import BodyNames, entity_of
from bt_manip.cell.objects import DeclaredGrasp
from bt_manip.toml import TomlTable

from .errors import GripperError, RobotError
from .grasp_candidates import GraspCandidates

if TYPE_CHECKING:
    from .connection import GripperConnection
    from .robot import Robot

GRIP_FORCE = 50.0
"""Force to grip with, of grippers that are strong enough [N]."""

_WEAK_SHARE = 0.8  # of the maximum force of others: a motor at its limit controls no force


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

    A kind implements the eight abstract methods, and names in `memory` what changes during a run.
    """

    kind: ClassVar[str] = "gripper"

    memory: ClassVar[tuple[str, ...]] = ()
    """Attributes of plain data that change during a run, for `get_state`."""

    def _build(self, robot: "Robot") -> None:
        """Initialize the control of a robot's gripper; subclasses extend this.

        Raises:
            RobotError: If the robot's description has no gripper.
        """
        description = robot.description.gripper
        if description is None:
            raise RobotError(f"robot '{robot.description.name}' has no gripper")
        self._mjcf_root = mjcf.RootElement(model=f"{self.kind}_gripper")
        self._description = description
        self.robot = robot
        """The robot that has this gripper."""
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

    @classmethod
    def on_device(cls, connection: "GripperConnection") -> "Callable[[Robot], Gripper]":
        """Return a factory of grippers of this kind that command a real one.

        Args:
            connection: Speaks to the real gripper.

        Raises:
            RobotError: If this kind has none; the default.
        """
        raise RobotError(f"grippers of kind '{cls.kind}' do not run on real robots")

    @property
    def mjcf_model(self) -> mjcf.RootElement:
        """An empty model, which composer attaches."""
        return self._mjcf_root

    @property
    def max_force(self) -> float:
        """Maximum grip force [N].

        Raises:
            RobotError: If the description does not give it and the kind does not override this.
        """
        description = self._description
        if description.max_force is None:
            table = description.read(self.robot.description.name)
            raise table.error("max_force", "is missing: the maximum grip force [N]")
        return description.max_force

    def default_force(self, preferred: float = GRIP_FORCE) -> float:
        """Return the force to grip with where none is given [N].

        Args:
            preferred: Force of grippers that are strong enough [N].
        """
        return preferred if self.max_force >= preferred else _WEAK_SHARE * self.max_force

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

    @property
    def min_object_width(self) -> float:
        """Width of the narrowest object that it grips [m]; 0 where it closes completely."""
        return 0.0

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

    def stop(self) -> None:  # noqa: B027
        """Stop at the current opening; a held object stays held. By default it goes on."""

    # Measurements

    @property
    def moving(self) -> bool:
        """Whether a command is still being executed."""
        return not (self.is_open or self.steady or self.closed_on_nothing)

    @property
    @abc.abstractmethod
    def is_open(self) -> bool:
        """Whether it is open, ready to grip and at rest."""

    @property
    @abc.abstractmethod
    def steady(self) -> bool:
        """Whether it has held with the commanded force for some time."""

    @property
    def closed_on_nothing(self) -> bool:
        """Whether it has closed without gripping anything; False for a kind that cannot tell."""
        return False

    @property
    def gripping(self) -> bool:
        """Whether its last command was to grip; a kind that knows overrides this."""
        return self.steady or self.closed_on_nothing

    @property
    def is_free(self) -> bool:
        """Whether it may move away: it touches nothing that moves with it."""
        return self.held_root() == 0

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the held entities; by default that of `held_root`."""
        root = self.held_root()
        return (entity_of(self.body_names.of_body[root]),) if root else ()

    @property
    @abc.abstractmethod
    def forces(self) -> tuple[float, ...]:
        """Force on the held object in the last step, one per gripping surface [N]."""

    @property
    def status(self) -> str:
        """Short description of its state: the forces or the opening."""
        return "open" if self.is_open else f"presses with {max(self.forces):.1f} N at most"

    # A real gripper

    def update(self) -> None:
        """Read the state of a real gripper, before each tick; default: there is none."""

    def close_connection(self) -> None:
        """End the connection to a real gripper; default: there is none."""
        self.close_link()

    def close_link(self) -> None:
        """Do the same under the former name, for one release."""

    def follow_tool(self, T_wt: pin.SE3) -> None:
        """Write what a real gripper has measured into the physics; default: there is none.

        Args:
            T_wt: Measured pose of the tool in the world.
        """

    # Geometry

    @property
    def contact_bodies(self) -> Sequence[Any]:
        """Bodies of the robot's model (PyMJCF elements) that may touch a gripped object.

        By default those of the gripper's own model, or the tool's body and all that it carries.
        """
        if self._description.model is not None:
            return list(self.robot.gripper_root.find_all("body"))
        body = self.robot.tool_site.parent
        return [body, *body.find_all("body")]

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

    def declared_grasp_generator(
        self,
        name: str,
        grasps: Sequence[DeclaredGrasp],
        geom_poses: Mapping[int, pin.SE3],
        com: np.ndarray,
    ) -> GraspGenerator | None:
        """Return a generator of the grasps that an object declares.

        None, the default, for a kind that grips in another way: its own are generated.

        Args:
            name: Name of the object, for messages.
            grasps: One or more grasps for two fingers.
            geom_poses: As for `grasp_generator`.
            com: The object's centre of mass, in its frame [m].  # (3,)
        """
        return None

    @property
    def contact_body_ids(self) -> tuple[int, ...]:
        """Ids of the contact bodies in the compiled model."""
        model = self.robot.mj_model
        if self._ids is None or self._ids[0] is not model:
            names = [body.full_identifier for body in self.contact_bodies]
            self._ids = model, tuple(int(model.body(name).id) for name in names)
        return self._ids[1]

    @property
    def body_names(self) -> BodyNames:
        """Names ``entity/body`` of the bodies and geoms of the compiled model."""
        model = self.robot.mj_model
        if self._names is None or self._names[0] is not model:
            self._names = model, BodyNames(model)
        return self._names[1]

    # State

    def get_state(self) -> dict[str, Any]:
        """Return the state kept between steps, as plain data: by default the `memory`."""
        return {name.lstrip("_"): getattr(self, name) for name in self.memory}

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state returned by ``get_state``."""
        for name in self.memory:
            setattr(self, name, state[name.lstrip("_")])
