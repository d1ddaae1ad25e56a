"""Position and force control of two fingers."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
from dm_control import mjcf

from bt_manip.cell.objects import DeclaredGrasp
from bt_manip.robots import Gripper, Robot
from bt_manip.toml import TomlTable

from ..solids import Solid
from .antipodal_grasps import AntipodalGraspGenerator
from .contacts import FingerContacts, Touched, held_root
from .declared_grasps import DeclaredGraspGenerator
from .hand import Hand, measure_hand
from .mechanism import Fingers, LinkedFingers, Mechanism, SlidingFingers
from .parameters import KIND, read_parameters
from .press import Press
from .stroke import Motion, Stroke, StrokeLimits

STILL = "still"
MOVING = "moving"
CLOSING = "closing"
GRIPPING = "gripping"
RELEASING = "releasing"
PRESSING = (GRIPPING, RELEASING)
"""States in which the fingers are force-controlled."""

RAMP = 0.05
"""Duration of a change of the force [s]."""
MET = 1e-3
"""Opening, above the minimum, up to which the fingers count as closed on each other [m]."""

_TOUCHED = 0.2  # [N] normal force above which a finger is in contact
_SPEED = 0.1  # [m/s] speed of each finger, unless its maximum is lower
_SLOW = 0.04  # [m/s] speed of each finger after the first contact
_MOMENTUM = 0.1  # [N s] maximum momentum of a finger after the first contact
_STOPPING = 1.5e-3  # [m] stopping distance of a finger from its default speed
_STEADY_BAND = (0.95, 1.20)  # relative to the commanded force
_JAW_BAND = (0.95, 1.40)  # the same for a moving and a fixed jaw, which meet at an angle
_MET_FORCE = 5.0  # [N] force of fingers closed on each other
# Poles of a finger's position loop [rad/s], well below a tenth of the sampling rate (628 rad/s).
_POLE = 150.0
_PUSH = 20.0  # [N] maximum force of a finger under position control, or
_PUSH_SHARE = 1.5  # this factor on the force of its fastest motion, if larger

_NOTHING: Touched = ((), ())


class DrivenFingers(Gripper):
    """Controls two fingers in every step: position along a stroke, or grip force.

    Fingers with one motor each are synchronized by control, not by a constraint; a single motor
    gets the sum of both efforts. The fingers follow one jerk-limited
    stroke until both touch the object, slower after the first contact, and then press with a force
    that rises smoothly to the commanded one. A touch sensor, added to each finger by this entity,
    measures its normal force.
    """

    kind = KIND

    state: str
    """Control state: still, moving, closing, gripping or releasing."""
    _stroke: Stroke | None
    _forces: tuple[float, float] | None
    _touched: Touched | None

    def _build(self, robot: Robot) -> None:
        """Initialize the control of a robot's fingers.

        Raises:
            RobotError: If the robot has no gripper, or its model and description do not match.
        """
        super()._build(robot)
        name = robot.description.name
        self._parameters = parameters = read_parameters(self._description.read(name))
        self.mechanism = Mechanism(robot, parameters, self.max_force)
        travel = self.mechanism.travel
        self._open, self._min = travel.open_width, travel.min_width
        transmission = LinkedFingers if travel.mass else SlidingFingers
        self._fingers: LinkedFingers | SlidingFingers = transmission(self.mechanism)
        self._speed = min(_SPEED, parameters.max_speed)
        self._acceleration = StrokeLimits(self._speed).acceleration
        self._contacts = FingerContacts(robot.mjcf_model, self.mechanism)
        self._dt = 0.0
        self._reset()

    @classmethod
    def check_parameters(cls, table: TomlTable) -> None:
        """Check the parameters."""
        read_parameters(table)

    @property
    def width(self) -> float:
        """Distance between the fingers [m]."""
        s1, s2, _, _ = self._fingers.read()
        return s1 + s2

    @property
    def forces(self) -> tuple[float, float]:
        """Normal force on each finger in the last step [N], read on demand."""
        if self._forces is None:
            self._forces = self._contacts.forces()
        return self._forces

    @property
    def is_free(self) -> bool:
        """Whether the fingers touch no entity."""
        return not any(self._touch())

    @property
    def held(self) -> tuple[str, ...]:
        """Names of the entities that both fingers touch."""
        left, right = self._touch()
        return tuple(name for name in left if name in right)

    def required_friction(self, weight: float, force: float) -> float:
        """Return the sliding friction at both fingers that is needed to carry a weight [-]."""
        return weight / (2.0 * force)

    # Geometry

    @property
    def max_object_width(self) -> float:
        """The opening [m]."""
        return self._open

    @property
    def min_object_width(self) -> float:
        """The opening at which the fingers have closed on nothing [m]."""
        return float(self._min + MET)

    @property
    def contact_bodies(self) -> list[Any]:
        """The finger bodies."""
        return self.mechanism.fingers

    def held_root(self) -> int:
        """Return the root body of the free object that both fingers touch; 0 for none."""
        robot = self.robot
        return held_root(robot.mj_model, robot.mj_data, self.contact_body_ids)

    def set_opening(self, qpos: np.ndarray, share: float = 1.0) -> None:
        """Write the gripper's joint positions for an opening from closed (0) to open (1)."""
        self.mechanism.set_width(qpos, self._min + share * (self._open - self._min))

    def grasp_generator(
        self,
        name: str,
        solids: Sequence[Solid],
        geom_poses: Mapping[int, pin.SE3],
        com: np.ndarray,
        rng: np.random.Generator,
    ) -> AntipodalGraspGenerator:
        """Return the generator of antipodal grasps of an object."""
        return AntipodalGraspGenerator(name, solids, self._hand(geom_poses), com, rng)

    def declared_grasp_generator(
        self,
        name: str,
        grasps: Sequence[DeclaredGrasp],
        geom_poses: Mapping[int, pin.SE3],
        com: np.ndarray,
    ) -> DeclaredGraspGenerator:
        """Return the generator of the grasps that an object declares."""
        return DeclaredGraspGenerator(name, grasps, self._hand(geom_poses), com)

    def _hand(self, geom_poses: Mapping[int, pin.SE3]) -> Hand:
        robot = self.robot
        return measure_hand(robot.mj_model, self.mechanism, robot.tool_site_id, geom_poses)

    # Composer's hooks

    def after_compile(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Bind to the compiled model, keeping the contacts of the last step."""
        if self._dt:  # compiled before
            self._touch()
        model, data = physics.model.ptr, physics.data.ptr
        self.mechanism.bind(model)
        self._dt = float(model.opt.timestep)
        fingers = self._fingers
        fingers.bind(model, data)
        self._contacts.bind(model, data)
        self._acceleration = min(StrokeLimits(0.0).acceleration, self.max_force / fingers.mass)
        stoppable = math.sqrt(2.0 * self._acceleration * _STOPPING)
        self._speed = min(_SPEED, self._parameters.max_speed, stoppable)
        moving = max(fingers.mass * self._acceleration, fingers.loss * self._speed)
        self._loop = FingerLoop(fingers.mass, fingers.loss, moving)
        self._slow = min(_SLOW, _MOMENTUM / fingers.mass)

    def initialize_episode(
        self, physics: mjcf.Physics, random_state: np.random.RandomState
    ) -> None:
        """Reset, with the fingers open."""
        self._reset()
        data = self.robot.mj_data
        self.mechanism.set_width(data.qpos, self._open)
        self.mechanism.rest(data.qvel)
        self._motion = Motion(0.5 * self.width, 0.0, 0.0)

    def before_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Command the fingers for the next step."""
        if self.state == CLOSING:
            self._look_for_contact()
        fingers, loop = self._fingers.read(), self._loop
        if self.state in PRESSING:
            s1, s2, v1, v2 = fingers
            f1, f2 = self._press.forces(loop.stiffness, loop.damping, s1 - s2, v1, v2)
        else:
            f1, f2 = loop.forces(self._motion, fingers)
        self._fingers.push(f1, f2)

    def after_substep(self, physics: mjcf.Physics, random_state: np.random.RandomState) -> None:
        """Advance the stroke or the force."""
        self._forces = self._touched = None
        if self._stroke is not None:
            self._travel_on(self._stroke)
        elif self.state in PRESSING:
            self._press_on(*self.forces)

    # Internal

    def _reset(self) -> None:
        self.state = STILL
        self._motion = Motion(0.5 * self._open, 0.0, 0.0)
        self._stroke = None
        self._limits = self._stroke_limits()
        self._target = self._motion.s
        self._slowed = False
        self._asked = 0.0  # [N] force commanded by the last close()
        # A single moving jaw pushes the object to the fixed jaw, against the damping.
        pushing = self._fingers.mass if self.mechanism.travel.one_moves else 0.0
        self._press = Press(self.mechanism.travel.friction, pushing)
        self._in_band = 0  # steps
        self._forces = (0.0, 0.0)
        self._touched = _NOTHING

    def _touch(self) -> Touched:
        """Return the entities that each finger touched in the last step, read on demand."""
        if self._touched is None:
            self._touched = self._contacts.names() if any(self.forces) else _NOTHING
        return self._touched

    def _stroke_limits(self) -> StrokeLimits:
        limits = StrokeLimits(self._speed)
        slower = self._acceleration / limits.acceleration  # for heavy mechanisms
        return StrokeLimits(self._speed, limits.acceleration * slower, limits.jerk * slower)

    def _travel(self, target: float | None) -> None:
        self._stroke = Stroke(self._motion, target, self._limits)

    def _look_for_contact(self) -> None:
        left, right = self.forces
        one_moves = self.mechanism.travel.one_moves  # and pushes the object to the fixed jaw
        if (left > _TOUCHED and right > _TOUCHED) or (one_moves and left > _TOUCHED):
            met = self.width < self._min + MET
            self._begin_grip(_MET_FORCE if met else self._asked)
        elif (left > _TOUCHED or right > _TOUCHED) and not self._slowed:
            self._slowed = True
            self._limits = self._limits._replace(speed=min(self._limits.speed, self._slow))
            self._travel(0.5 * self._min)

    def _begin_grip(self, force: float) -> None:
        s1, s2, _, _ = self._fingers.read()
        self._press.begin(s1 - s2)
        self._change_force(GRIPPING, force, RAMP)

    def _change_force(self, state: str, force: float, duration: float) -> None:
        self.state, self._stroke = state, None
        self._press.change(force, duration)

    def _travel_on(self, stroke: Stroke) -> None:
        self._motion = stroke.advance(self._dt)
        if stroke.done:
            self._stroke = None
            if self.state == MOVING:
                self.state = STILL
            elif self.state == CLOSING:  # no contact along the whole stroke
                self._begin_grip(_MET_FORCE)

    def _press_on(self, left: float, right: float) -> None:
        one_moves = self.mechanism.travel.one_moves
        measured = min(left, right) if one_moves else 0.5 * (left + right)
        arrived = self._press.advance(self._dt, measured)
        if arrived and self.state == RELEASING:
            self._motion = Motion(0.5 * self.width, 0.0, 0.0)
            self._travel(self._target)
            self.state = MOVING
            return
        band = _JAW_BAND if one_moves else _STEADY_BAND
        low, high = band[0] * self._asked, band[1] * self._asked
        inside = low <= left <= high and low <= right <= high
        self._in_band = self._in_band + 1 if inside else 0

    # State

    def get_state(self) -> dict[str, Any]:
        """Return the state kept between steps, as plain data."""
        return {
            "state": self.state,
            "motion": list(self._motion),
            "stroke": None if self._stroke is None else self._stroke.get_state(),
            "limits": list(self._limits),
            "target": self._target,
            "slowed": self._slowed,
            "asked": self._asked,
            "press": self._press.get_state(),
            "in_band": self._in_band,
            "forces": list(self.forces),
            "touched": [list(names) for names in self._touch()],
        }

    def set_state(self, state: Mapping[str, Any]) -> None:
        """Restore a state returned by ``get_state``."""
        stroke = state["stroke"]
        left, right = state["touched"]
        self.state = state["state"]
        self._motion = Motion(*state["motion"])
        self._stroke = None if stroke is None else Stroke.from_state(stroke)
        self._limits = StrokeLimits(*state["limits"])
        self._target, self._slowed = state["target"], state["slowed"]
        self._asked, self._in_band = state["asked"], state["in_band"]
        self._press.set_state(state["press"])
        first, second = state["forces"]
        self._forces = (first, second)
        self._touched = (tuple(left), tuple(right))


class FingerLoop:
    """A PD position loop with two equal poles and acceleration feedforward for each finger.

    A finger with more viscous friction keeps it, and has a slower pole: feedback that cancels
    friction oscillates where the force is limited.

    Args:
        mass: Effective mass of one finger [kg].
        loss: Viscous friction of one finger [N s/m].
        moving: Force that accelerates one finger, or keeps its speed [N].

    Attributes:
        stiffness: Position gain of a finger [N/m].
        damping: Velocity gain of a finger, including its viscous friction [N s/m].
    """

    def __init__(self, mass: float, loss: float, moving: float) -> None:
        self._push = max(_PUSH, _PUSH_SHARE * moving)
        self._mass = mass
        self.damping = max(2.0 * mass * _POLE, loss)
        self.stiffness = 0.5 * self.damping * _POLE
        self._added = self.damping - loss  # the rest is viscous friction

    def forces(self, motion: Motion, fingers: Fingers) -> tuple[float, float]:
        """Return the forces that make the fingers follow a motion, positive to open [N].

        Args:
            motion: Desired motion of each finger.
            fingers: Measured positions and velocities of the fingers.
        """
        s, v, a = motion
        s1, s2, v1, v2 = fingers
        k, added = self.stiffness, self._added
        ahead = self._mass * a + self.damping * v + k * s
        f1 = ahead - k * s1 - added * v1
        f2 = ahead - k * s2 - added * v2
        push = self._push
        if -push < f1 < push and -push < f2 < push:
            return f1, f2
        return min(max(f1, -push), push), min(max(f2, -push), push)
