"""A gripper with one suction cup."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import entity_of
from bt_manip.grippers import Solid
from bt_manip.robots import Gripper, GripperError, Robot
from bt_manip.toml import TomlTable

from .cup import Cup, adhesion_actuators
from .cup_grasps import CupGraspGenerator
from .lip import seals
from .parameters import read_parameters

OPEN = "open"
CLOSING = "closing"
SEALED = "sealed"
LOST = "lost"
"""State without a seal after `close`: none has formed, or it has broken."""

_RAMP = 0.05  # [s] rise time of the force
_RELEASE = 0.02  # [s] fall time of the force
_SEAL_TIME = 0.05  # [s] of a seal until the grip is steady
_SEAL_TIMEOUT = 0.5  # [s] within which a seal has to form
_CHECK_INTERVAL = 10  # steps between two checks that the object covers the whole lip
_MAX_INTERRUPTION = 5e-3  # [s] without contact after which a seal is broken


class SuctionGripper(Gripper):
    """Holds one object by the vacuum in a cup, modelled by MuJoCo's adhesion.

    After `close`, the force rises while an object covers the whole lip; the cup is sealed once it
    has the commanded force in contact. The seal breaks when the contact opens, or when the object
    no longer covers the lip, and does not form again until the next `close`.
    """

    kind = "suction"
    memory = (
        "state", "_asked", "_force", "_pressing", "_object", "_time", "_interrupted", "_steps",
    )  # fmt: skip

    def _build(self, robot: Robot) -> None:
        """Initialize the control of a robot's suction cup, and build the cup if it has none.

        Raises:
            RobotError: If the robot has no gripper, or its model and description do not match.
        """
        super()._build(robot)
        table = self._description.read(robot.description.name)
        if self._description.max_force is not None:
            raise table.error(
                "max_force",
                "follows from 'pressure' and 'diameter', or from the model: leave it out",
            )
        built = not adhesion_actuators(robot.gripper_root)
        self.cup = Cup(robot, read_parameters(table, built))
        self._reset()

    def _reset(self) -> None:
        self.state = OPEN
        self._asked = 0.0  # [N] force commanded by the last close()
        self._force = 0.0  # [N] force of the vacuum
        self._pressing = 0.0  # [N] force of the lip in the last step
        self._object = ""  # entity that covers the lip
        self._time = 0.0  # [s] in the present state
        self._interrupted = 0.0  # [s] without contact
        self._steps = 0  # since the cup was sealed

    @classmethod
    def check_parameters(cls, table: TomlTable) -> None:
        """Check the parameters, assuming that the model has a cup."""
        read_parameters(table, built=False)

    @property
    def max_force(self) -> float:
        """Holding force [N]: the pressure difference times the area of the cup."""
        return self.cup.max_force

    def required_friction(self, weight: float, force: float) -> float:
        """Return zero: suction carries the weight.

        Raises:
            GripperError: If the weight exceeds the force [N].
        """
        if weight > force:
            raise GripperError(f"the cup holds {force:.3g} N, the object weighs {weight:.3g} N")
        return 0.0

    # Commands

    def open(self) -> None:
        """Release the vacuum."""
        self.state, self._asked = OPEN, 0.0

    def close(self, force: float) -> None:
        """Evacuate the cup until it is sealed and holds with a force [N].

        Raises:
            GripperError: If the cup cannot hold with this force.
        """
        self._asked = self.check_force(force)
        if self.state != SEALED:
            self.state, self._object, self._time = CLOSING, "", 0.0

    def stop(self) -> None:
        """Stop evacuating; a held object stays held."""
        if self.state == CLOSING:
            self.open()

    # Measurements

    @property
    def is_open(self) -> bool:
        """Whether there is no vacuum."""
        return self.state == OPEN and self._force == 0.0

    @property
    def gripping(self) -> bool:
        """Whether its last command was to close."""
        return self.state != OPEN

    @property
    def steady(self) -> bool:
        """Whether it has been sealed with the commanded force for 50 ms."""
        return (
            self.state == SEALED and self._time >= _SEAL_TIME - 1e-9 and self._force == self._asked
        )

    @property
    def closed_on_nothing(self) -> bool:
        """Whether no seal has formed, or it has broken."""
        return self.state == LOST

    @property
    def is_free(self) -> bool:
        """Whether there is no vacuum, so that a touched object does not move with the cup."""
        return self._force == 0.0

    @property
    def held(self) -> tuple[str, ...]:
        """Name of the entity that seals the cup."""
        return (self._object,) if self.state == SEALED else ()

    @property
    def forces(self) -> tuple[float]:
        """Force of the lip on the held object in the last step [N]."""
        return (self._pressing,)

    @property
    def status(self) -> str:
        """Short description: the holding force, and whether it is sealed."""
        if self.state == SEALED:
            return f"cup sealed, holds up to {self._force:.1f} N"
        return {OPEN: "cup without vacuum", CLOSING: "cup not sealed yet"}.get(
            self.state, "cup lost its seal" if self._object else "cup found nothing that seals it"
        )

    # Geometry

    @property
    def contact_bodies(self) -> list[Any]:
        """The body of the cup."""
        return [self.cup.body]

    def held_root(self) -> int:
        """Return the root body of the free object that seals the cup; 0 for none."""
        model, held = self.robot.mj_model, self.held
        for body in np.flatnonzero(model.body_dofnum == 6) if held else ():
            if entity_of(self.body_names.of_body[body]) == held[0]:
                return int(body)
        return 0

    def set_opening(self, qpos: np.ndarray, share: float = 1.0) -> None:
        """Do nothing: a cup has no joints."""

    def grasp_generator(
        self,
        name: str,
        solids: Sequence[Solid],
        geom_poses: Mapping[int, pin.SE3],
        com: np.ndarray,
        rng: np.random.Generator,
    ) -> CupGraspGenerator:
        """Return the generator of grasps on the faces of an object."""
        return CupGraspGenerator(name, solids, self.cup.radius, com, hollow=self.cup.hollow)

    # Composer's hooks

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model."""
        self.cup.bind(physics.model.ptr)

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Reset, without vacuum."""
        self._reset()

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the force for the next step."""
        self.robot.mj_data.ctrl[self.cup.ctrl] = self._force / self.cup.gain

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Measure the contact; update the force and the seal."""
        if self.state in (OPEN, LOST) and self._force == self._pressing == 0.0:
            return
        model, data = self.robot.mj_model, self.robot.mj_data
        dt = float(model.opt.timestep)
        self._pressing = float(data.sensordata[self.cup.sensor])
        if self.state in (OPEN, LOST):
            self._force = max(self._force - self.max_force * dt / _RELEASE, 0.0)
            return
        self._time += dt
        if self.state == CLOSING:
            self._object = self._covering(self._near())
            if self._time >= _SEAL_TIMEOUT:
                self.state, self._object = LOST, ""
        else:
            self._interrupted = 0.0 if self._pressing > 0.0 else self._interrupted + dt
            self._steps += 1
            checked = self._steps % _CHECK_INTERVAL == 0
            if self._interrupted > _MAX_INTERRUPTION or (
                checked and not self._covering([self._object])
            ):
                self.state, self._force = LOST, 0.0
                return
        rising = self._force + self.max_force * dt / _RAMP
        self._force = min(rising, self._asked) if self._object else 0.0
        if self.state == CLOSING and self._force == self._asked and self._pressing > 0.0:
            self.state, self._time, self._interrupted, self._steps = SEALED, 0.0, 0.0, 0

    # Internal

    def _near(self) -> list[str]:
        """Return the entities within the travel of the lip, sorted by name."""
        label = self.body_names.of_geom
        pairs = self.robot.mj_data.contact.geom
        own = np.isin(pairs, self.cup.geoms)
        others = pairs[:, ::-1][own & ~own[:, ::-1]]
        return sorted({entity_of(label[geom]) for geom in others})

    def _covering(self, entities: Sequence[str]) -> str:
        """Return the first entity that covers the whole lip; empty without one."""
        model, data = self.robot.mj_model, self.robot.mj_data
        solid = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
        for name in entities:
            try:
                geoms = np.flatnonzero(self.body_names.geoms(name) & solid)
            except KeyError:  # it is no longer in the cell
                continue
            if seals(model, data, self.robot.tool_site_id, self.cup.radius, geoms.tolist()):
                return name
        return ""
