"""A multi-finger hand that closes along a synergy."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, TypeAlias, TypeVar

import mujoco
import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell import entity_of
from bt_manip.grippers import Solid
from bt_manip.robots import FoundGripper, Gripper, Robot, ensure_motors
from bt_manip.toml import Key, TomlTable, documented, read_part

from .hand_search import find_hand
from .touch import add_touch_sensor
from .wrap_grasps import WrapGraspGenerator, measure

T = TypeVar("T", str, int)

Names: TypeAlias = tuple[str, ...]
Numbers: TypeAlias = tuple[float, ...]

OPEN = "open"
CLOSING = "closing"
STOPPED = "stopped"

_DURATION = 0.8  # [s] to close from fully open to fully closed
_WRAP_STEADY_BAND = (0.8, 1.3)  # relative to the commanded force
_WRAP_STEADY_TIME = 0.1  # [s] inside the band until the grip is steady
_AT_POSTURE = 0.06  # [rad] largest deviation from the open posture of an open hand
_PATIENCE = 0.3  # [s] fully closed, or with thumb on finger, until it has closed on nothing


@documented
@dataclass(frozen=True)
class HandParameters:
    """Parameters of a hand, which are keys of ``[gripper]``."""

    palm: Annotated[str, Key("Name of the body that carries the fingers")]
    thumb: Annotated[str, Key("Name of the thumb's first body")]
    fingers: Annotated[Names, Key("Names of the first bodies of the fingers that oppose the thumb")]
    joints: Annotated[Names, Key("Names of all joints of the hand")]
    open: Annotated[Numbers, Key("Joint positions of the open hand", "rad", size="joints")]
    closed: Annotated[Numbers, Key("Joint positions of the closed hand", "rad", size="joints")]
    effort: Annotated[Numbers, Key("Effort limits of the joints", "N m", above=0.0, size="joints")]
    stiffness: Annotated[
        Numbers,
        Key(
            "Torque of each joint per deviation from its reference",
            "N m/rad",
            above=0.0,
            size="joints",
        ),
    ]
    max_width: Annotated[
        float, Key("Width of the widest object between thumb and fingers", "m", above=0.0)
    ]


class Hand(Gripper):
    """Wraps its fingers around an object, along a line between two postures (a synergy).

    All joints follow ``open + s (closed - open)`` as springs with limited torque: links stopped by
    an object yield, while others close further. The position s on the line is controlled so that
    the thumb presses with the commanded force; the fingers press against it.
    """

    kind = "hand"
    memory = ("state", "_asked", "_s", "_force", "_time", "_idle")

    def _build(self, robot: Robot) -> None:
        """Initialize the control of a robot's hand.

        Raises:
            RobotError: If the robot has no gripper, or its model and description do not match.
        """
        super()._build(robot)
        table = self._description.read(robot.description.name)
        parameters = read_part(HandParameters, table)
        assert parameters is not None  # otherwise the table raises an error
        self._max_width = parameters.max_width
        self._joints = [robot.find("joint", name) for name in parameters.joints]
        self._open, self._closed = np.array(parameters.open), np.array(parameters.closed)
        self._effort, self._stiffness = np.array(parameters.effort), np.array(parameters.stiffness)
        efforts = self._effort.tolist()
        self._motors = ensure_motors(robot.mjcf_model, robot.alone, self._joints, efforts)
        palm, thumb = (robot.find("body", name) for name in (parameters.palm, parameters.thumb))
        fingers = [robot.find("body", name) for name in parameters.fingers]
        self._thumb = [thumb, *thumb.find_all("body")]
        self._fingers = [body for f in fingers for body in (f, *f.find_all("body"))]
        self._bodies = [palm, *self._thumb, *self._fingers]
        for body in self._bodies:
            for geom in body.find_all("geom", immediate_children_only=True):
                # For geoms of equal priority MuJoCo uses the larger friction: that of the object.
                geom.set_attributes(friction=(0.0, 0.01, 0.0), condim=4, priority=0)
        self._sensors = [add_touch_sensor(body, f"{body.name}_touch") for body in self._thumb]
        self._reset()

    def _reset(self) -> None:
        self.state = OPEN
        self._asked = 0.0  # [N] force commanded by the last close()
        self._s = 0.0  # position on the synergy: 0 for open, 1 for closed
        self._force = 0.0  # [N] of the thumb in the last step
        self._time = 0.0  # [s] in the force band
        self._idle = 0.0  # [s] closed on nothing

    @classmethod
    def check_parameters(cls, table: TomlTable) -> None:
        """Check the parameters."""
        read_part(HandParameters, table)

    @classmethod
    def found_in(cls, model: mujoco.MjModel, arm_joints: Sequence[str]) -> FoundGripper | None:
        """Return a hand found in a model."""
        return find_hand(model, arm_joints)

    @property
    def max_object_width(self) -> float:
        """Width of the widest object that fits the open hand [m]."""
        return self._max_width

    def required_friction(self, weight: float, force: float) -> float:
        """Return the sliding friction at thumb and fingers that is needed to carry a weight [-]."""
        return weight / (2.0 * force)

    # Commands

    def open(self) -> None:
        """Open along the synergy."""
        self.state, self._asked, self._time = OPEN, 0.0, 0.0

    def close(self, force: float) -> None:
        """Close until the thumb presses with a force [N].

        Raises:
            GripperError: If the hand cannot press with this force.
        """
        self._asked = self.check_force(force)
        self.state, self._time, self._idle = CLOSING, 0.0, 0.0

    def stop(self) -> None:
        """Stop at the present posture; a held object stays held."""
        if self.state == CLOSING or (self.state == OPEN and not self.is_open):
            self.state = STOPPED

    # Measurements

    @property
    def moving(self) -> bool:
        """Whether a command is still being executed."""
        return self.state != STOPPED and super().moving

    @property
    def is_open(self) -> bool:
        """Whether all joints are at the open posture."""
        errors = self.robot.mj_data.qpos[self._qpos] - self._open
        return self.state == OPEN and self._s == 0.0 and bool(np.abs(errors).max() < _AT_POSTURE)

    @property
    def gripping(self) -> bool:
        """Whether its last command was to close."""
        return self.state == CLOSING

    @property
    def steady(self) -> bool:
        """Whether thumb and fingers hold an object with approximately the commanded force."""
        return self.state == CLOSING and self._time >= _WRAP_STEADY_TIME - 1e-9

    @property
    def closed_on_nothing(self) -> bool:
        """Whether the hand has closed without an object between thumb and fingers."""
        return self.state == CLOSING and self._idle >= _PATIENCE

    @property
    def is_free(self) -> bool:
        """Whether thumb and fingers touch no entity."""
        return not self._touching(self._thumb_ids | self._finger_ids)

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the entities that the thumb and a finger touch."""
        label = self.body_names.of_body
        return tuple(self._between(lambda body: entity_of(label[body])))

    @property
    def forces(self) -> tuple[float]:
        """Force of the thumb in the last step [N]."""
        return (self._force,)

    @property
    def status(self) -> str:
        """Short description: the closure, and the force of the thumb."""
        return f"hand {100.0 * self._s:.0f} % closed, thumb presses with {self._force:.1f} N"

    # Geometry

    @property
    def contact_bodies(self) -> list[Any]:
        """Palm, thumb and fingers."""
        return self._bodies

    def held_root(self) -> int:
        """Return the root body of the free object that the thumb and a finger touch; 0: none."""
        model = self.robot.mj_model
        roots = self._between(lambda body: int(model.body_rootid[body]))
        return next((root for root in roots if model.body_dofnum[root] == 6), 0)

    def set_opening(self, qpos: np.ndarray, share: float = 1.0) -> None:
        """Write the joint positions of a posture from closed (0) to open (1)."""
        qpos[self._qpos] = self._posture(1.0 - share)

    def grasp_generator(
        self,
        name: str,
        solids: Sequence[Solid],
        geom_poses: Mapping[int, pin.SE3],
        com: np.ndarray,
        rng: np.random.Generator,
    ) -> WrapGraspGenerator:
        """Return the generator of grasps that wrap an object."""
        model = self.robot.mj_model
        thumb, fingers = (
            [geom for geom in geom_poses if int(model.geom_bodyid[geom]) in ids]
            for ids in (self._thumb_ids, self._finger_ids)
        )
        palm = [geom for geom in geom_poses if geom not in (*thumb, *fingers)]
        shape = measure(model, geom_poses, thumb, fingers, palm, self._max_width)
        return WrapGraspGenerator(name, solids, shape, com)

    # Composer's hooks

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model."""
        model = physics.model.ptr
        joints = [model.joint(joint.full_identifier).id for joint in self._joints]
        self._qpos, self._dofs = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
        self._ctrl = [model.actuator(motor.full_identifier).id for motor in self._motors]
        self._adr = [int(model.sensor(s.full_identifier).adr[0]) for s in self._sensors]
        self._thumb_ids, self._finger_ids = (
            {int(model.body(body.full_identifier).id) for body in bodies}
            for bodies in (self._thumb, self._fingers)
        )

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Reset, with the hand open."""
        self._reset()
        self.set_opening(self.robot.mj_data.qpos)
        self.robot.mj_data.qvel[self._dofs] = 0.0

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the torques for the next step."""
        data = self.robot.mj_data
        torque = self._stiffness * (self._posture(self._s) - data.qpos[self._qpos])
        data.ctrl[self._ctrl] = np.clip(torque, -self._effort, self._effort)

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Measure the thumb's force and advance along the synergy."""
        data = self.robot.mj_data
        dt = float(self.robot.mj_model.opt.timestep)
        self._force = sum(float(data.sensordata[adr]) for adr in self._adr)
        if self.state == STOPPED:
            return
        if self.state == OPEN:
            self._s = max(self._s - dt / _DURATION, 0.0)
            return
        error = float(np.clip((self._asked - self._force) / self._asked, -1.0, 1.0))
        self._s = min(max(self._s + error * dt / _DURATION, 0.0), 1.0)
        low, high = (share * self._asked for share in _WRAP_STEADY_BAND)
        holds = self._force > 0.0 and bool(self.held)
        self._time = self._time + dt if holds and low <= self._force <= high else 0.0
        done = self._s == 1.0 or self._force > low
        self._idle = self._idle + dt if done and not holds else 0.0

    # Internal

    def _posture(self, s: float) -> np.ndarray:
        """Return the joint positions at a position on the synergy [rad]."""  # (n,)
        return np.asarray(self._open + s * (self._closed - self._open))

    def _between(self, of_body: Callable[[int], T]) -> list[T]:
        """Return, in order, what bodies touched by the thumb and by a finger have in common."""
        thumb, fingers = (
            {of_body(body) for body in self._touching(ids)}
            for ids in (self._thumb_ids, self._finger_ids)
        )
        return sorted(thumb & fingers)

    def _touching(self, bodies: set[int]) -> set[int]:
        """Return the bodies of other entities touched by given bodies of the hand."""
        model, data = self.robot.mj_model, self.robot.mj_data
        own = self._thumb_ids | self._finger_ids
        found = set()
        for first, second in model.geom_bodyid[data.contact.geom].tolist():
            for mine, other in ((first, second), (second, first)):
                if mine in bodies and model.body_rootid[other] != model.body_rootid[mine]:
                    found.add(other)
        return found - own
