"""The joints, fingers and motors of a gripper in its robot's model, and their transmissions."""

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from bt_manip.cell import escaped_name, literal_name
from bt_manip.robots import Robot, RobotError, effort_limit, ensure_motors

from ..solids import collision_geoms_of
from .finger_travel import FingerTravel
from .parameters import PadParameters, TwoFingerParameters
from .travel_check import checked_travel

_TOLERANCE = 2e-3  # [m] tolerance of a described opening
_STIFF = {"solref": (0.004, 1.0), "solimp": (0.99, 0.999, 0.001)}  # of coupled joints
_SOLMIX = 1e6  # weight of the fingers' contact parameters; that of other geoms is 1

Fingers = tuple[float, float, float, float]
"""Distances of the two fingers from the centre [m], and their velocities [m/s]."""


class Mechanism:
    """Mechanism of a robot's two fingers, with motors in place of the model's actuators.

    Args:
        robot: The robot, not compiled yet.
        parameters: Parameters of the gripper.
        max_force: Maximum force of each finger [N].

    Attributes:
        fingers: The finger bodies, as PyMJCF elements.
        travel: Travel of the fingers as a function of their joints.
        actuators: The motors: one for each joint, or one for both.
        qpos_adr: Addresses of the fingers' joints in ``qpos``, once compiled.  # (2,)
        dof_adr: Addresses of the fingers' joints in ``qvel``, once compiled.  # (2,)
        ctrl_adr: Addresses of the motors in ``ctrl``, once compiled.
        geoms: Ids of each finger's collision geoms, once compiled.

    Raises:
        RobotError: If the model has no such joints and fingers, or their travel was not measured.
    """

    def __init__(self, robot: Robot, parameters: TwoFingerParameters, max_force: float) -> None:
        where = f"robot '{robot.description.name}'"
        self.joints = [robot.find("joint", name) for name in parameters.joints]
        self.fingers = [robot.find("body", name) for name in parameters.fingers]
        self._robot, root = robot, robot.mjcf_model
        self.travel = _limited(checked_travel(robot, parameters), parameters, where)
        self._set_contacts(parameters)
        self._set_joints(parameters)
        driven, motor = self.joints, self.travel.motor
        if motor is not None:
            tendon = robot.gripper_root.find("tendon", escaped_name(motor))
            driven = [tendon or robot.find("joint", motor)]
        self._moving = [robot.find("joint", name) for name in self.travel.joints]
        self._stiffen_couplings()
        efforts = self._efforts(parameters, max_force)
        self.actuators = ensure_motors(root, robot.alone, driven, efforts, freed=self._moving)
        if self.travel.one_moves:
            self._stop_at_fixed_finger()

    def _stop_at_fixed_finger(self) -> None:
        """Limit the joint where the fingers meet: MuJoCo ignores parent-child contacts."""
        (joint,), travel = self.joints, self.travel
        column = travel.joints.index(literal_name(joint.name))
        ends = travel.positions[column]
        closed = travel.configuration(travel.min_width)[column]
        lower, upper = self._robot.alone.joint(joint.full_identifier).range
        limits = np.array([closed, upper] if ends[-1] > ends[0] else [lower, closed])
        in_degrees = joint.type != "slide" and joint.root.compiler.angle != "radian"
        joint.range, joint.limited = np.degrees(limits) if in_degrees else limits, "true"

    def _set_contacts(self, parameters: TwoFingerParameters) -> None:
        """Give contacts the friction of the touched object and the stiffness of the fingers.

        For geoms of equal priority, MuJoCo uses the larger friction, and averages ``solref`` and
        ``solimp`` with the weights ``solmix``.
        """
        pads = parameters.pads or PadParameters()
        given = {"solref": pads.solref, "solimp": pads.solimp}
        given = {key: value for key, value in given.items() if value is not None}
        for finger in self.fingers:
            for geom in finger.find_all("geom", immediate_children_only=True):
                geom.set_attributes(friction=(0, 0, 0), priority=0, solmix=_SOLMIX, **given)

    def _set_joints(self, parameters: TwoFingerParameters) -> None:
        """Replace armature and dry friction of all joints of the mechanism."""
        changes = {"armature": parameters.armature, "frictionloss": parameters.frictionloss}
        given = {key: value for key, value in changes.items() if value is not None}
        for base in [joint.parent.parent for joint in self.joints] if given else ():
            for joint in base.find_all("joint"):
                if joint.parent is not base:
                    joint.set_attributes(**given)

    def _stiffen_couplings(self) -> None:
        """Couple joints stiffly where the model leaves MuJoCo's default, as every URDF does.

        With the default, joints of light links yield to a grip by tenths of a radian.
        """
        for coupling in self._robot.gripper_root.equality.joint:
            given = (coupling.solref, coupling.dclass, coupling.root.default.equality.solref)
            coupled = any(coupling.joint1 is joint for joint in self._moving)
            if coupled and all(value is None for value in given):
                coupling.set_attributes(**_STIFF)

    def _efforts(self, parameters: TwoFingerParameters, max_force: float) -> list[float]:
        """Return the maximum effort of each motor.

        For slides this is the smaller limit of model and description, for other mechanisms that of
        the description: a model's servo gains are no measure of the real force.
        """
        if self.travel.mass:
            return self.travel.efforts(max_force, parameters.joints)
        alone, names = self._robot.alone, [joint.full_identifier for joint in self.joints]
        return [min(effort_limit(alone, int(alone.joint(name).id)), max_force) for name in names]

    def bind(self, model: mujoco.MjModel) -> None:
        """Read the addresses from a compiled model."""

        def ids(joints: list[Any]) -> list[int]:
            return [int(model.joint(joint.full_identifier).id) for joint in joints]

        own, moving = ids([self.joints[0], self.joints[-1]]), ids(self._moving)
        self.qpos_adr, self.dof_adr = model.jnt_qposadr[own], model.jnt_dofadr[own]
        self._moving_qpos_adr, self._moving_dof_adr = (
            model.jnt_qposadr[moving],
            model.jnt_dofadr[moving],
        )
        self.ctrl_adr = np.array(
            [model.actuator(motor.full_identifier).id for motor in self.actuators], dtype=np.intp
        )
        bodies = [int(model.body(finger.full_identifier).id) for finger in self.fingers]
        self.geoms = tuple(tuple(collision_geoms_of(model, body)) for body in bodies)

    def set_width(self, qpos: np.ndarray, width: float) -> None:
        """Write the positions of all moving joints at an opening [m] into a ``qpos``."""
        qpos[self._moving_qpos_adr] = self.travel.configuration(width)

    def rest(self, qvel: np.ndarray) -> None:
        """Set the velocities of all moving joints in a ``qvel`` to zero."""
        qvel[self._moving_dof_adr] = 0.0


def _limited(travel: FingerTravel, parameters: TwoFingerParameters, where: str) -> FingerTravel:
    """Return the travel limited to the described openings, which the model has to reach."""
    low, high = travel.min_width, travel.open_width
    described = parameters.open_width
    if described is not None and described > high + _TOLERANCE:
        raise RobotError(
            f"{where}: gripper.open_width is {1e3 * described:.1f} mm, but the fingers of the "
            f"model open to {1e3 * high:.1f} mm; give at most this, or leave it out"
        )
    high = high if described is None else min(described, high)
    low = max(parameters.min_width, low)
    if high - low < _TOLERANCE:
        raise RobotError(
            f"{where}: gripper.open_width is {1e3 * high:.1f} mm, but the fingers of the model "
            f"close to {1e3 * low:.1f} mm only; give more, or leave it out"
        )
    return replace(travel, open_width=high, min_width=low)


class SlidingFingers:
    """Transmission of fingers on slides with a motor each: s = offset + sign * q.

    Attributes:
        mass: Effective mass of one finger [kg].
        loss: Viscous friction of one finger [N s/m].
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self.mass = self.loss = 0.0

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Bind to a compiled model."""
        mechanism = self._mechanism
        (p1, p2), (d1, d2) = mechanism.qpos_adr.tolist(), mechanism.dof_adr.tolist()
        u1, u2 = mechanism.ctrl_adr.tolist()
        (b1, a1), (b2, a2) = mechanism.travel.polynomials
        # One tuple: separate attribute lookups would take longer than the computation.
        self._bound = (data.qpos.item, data.qvel.item, p1, p2, d1, d2, b1, b2, a1, a2)
        self._motors = (data.ctrl, u1, u2, a1, a2)
        self.mass = float(model.dof_M0[[d1, d2]].mean())
        self.loss = float(model.dof_damping[[d1, d2]].mean())

    def read(self) -> Fingers:
        """Return the positions and velocities of the fingers."""
        position, velocity, p1, p2, d1, d2, b1, b2, a1, a2 = self._bound
        return b1 + a1 * position(p1), b2 + a2 * position(p2), a1 * velocity(d1), a2 * velocity(d2)

    def push(self, first: float, second: float) -> None:
        """Apply a force to each finger, positive to open [N]."""
        ctrl, u1, u2, a1, a2 = self._motors
        ctrl[u1] = a1 * first
        ctrl[u2] = a2 * second


class LinkedFingers:
    """Transmission of fingers that follow a joint each, with one motor for both or one each.

    Motor efforts follow from finger forces by the principle of virtual work, plus the efforts that
    balance springs. Friction of the mechanism is compensated by force feedback, not here.

    Attributes:
        mass: Effective mass of one finger [kg].
        loss: Viscous friction of one finger [N s/m].
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        travel = mechanism.travel
        self.mass, self.loss = travel.mass, travel.loss
        self._travels = travel.polynomials
        self._slopes = [tuple(k * c for k, c in enumerate(p))[1:] for p in travel.polynomials]
        self._hold1, self._hold2 = travel.holding
        self._r1, self._r2 = travel.ratios
        self._at = (0.0, 0.0)

    def bind(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Bind to a compiled model."""
        mechanism = self._mechanism
        (p1, p2), (d1, d2) = mechanism.qpos_adr.tolist(), mechanism.dof_adr.tolist()
        self._bound = (data.qpos.item, data.qvel.item, p1, p2, d1, d2)
        self._ctrl, self._motors = data.ctrl, mechanism.ctrl_adr.tolist()

    def read(self) -> Fingers:
        """Return the positions and velocities of the fingers."""
        position, velocity, p1, p2, d1, d2 = self._bound
        q1, q2 = self._at = position(p1), position(p2)
        (travel1, travel2), (slope1, slope2) = self._travels, self._slopes
        return (
            _polynomial(travel1, q1),
            _polynomial(travel2, q2),
            _polynomial(slope1, q1) * velocity(d1),
            _polynomial(slope2, q2) * velocity(d2),
        )

    def push(self, first: float, second: float) -> None:
        """Apply a force to each finger, positive to open [N], at the last read positions."""
        q1, q2 = self._at
        slope1, slope2 = self._slopes
        effort1 = first * _polynomial(slope1, q1) * self._r1 + _polynomial(self._hold1, q1)
        effort2 = second * _polynomial(slope2, q2) * self._r2 + _polynomial(self._hold2, q2)
        if len(self._motors) == 1:
            self._ctrl[self._motors[0]] = effort1 + effort2
        else:
            self._ctrl[self._motors[0]] = effort1
            self._ctrl[self._motors[1]] = effort2


def _polynomial(coefficients: tuple[float, ...], x: float) -> float:
    """Evaluate a polynomial by Horner's rule, constant coefficient first."""
    value = 0.0
    for c in reversed(coefficients):
        value = value * x + c
    return value
