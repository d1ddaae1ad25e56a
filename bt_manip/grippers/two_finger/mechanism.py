"""The joints, fingers and motors of a gripper in its robot's model."""

import copy
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from bt_manip.cell import escaped_name
from bt_manip.robots import Robot, RobotError, effort_limit, ensure_motors, site_pose

from .finger_bench import FingerBench, collision_geoms_of
from .finger_travel import FingerTravel
from .parameters import PadParameters, TwoFingerParameters
from .travel_measurement import FingerNames, measure_travel

_TOLERANCE = 2e-3  # [m] tolerance of a described opening
_SOLMIX = 1e6  # weight of the fingers' contact parameters; that of other geoms is 1


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
        RobotError: If the model has no such joints and fingers.
    """

    def __init__(self, robot: Robot, parameters: TwoFingerParameters, max_force: float) -> None:
        where = f"robot '{robot.description.name}'"
        self.joints = [robot.find("joint", name) for name in parameters.joints]
        self.fingers = [robot.find("body", name) for name in parameters.fingers]
        self._robot, alone = robot, robot.alone
        root = robot.mjcf_model
        self._set_contacts(parameters)
        self._set_joints(parameters)
        bench = FingerBench(
            _with_joints(alone, self._bases, parameters),
            [joint.full_identifier for joint in robot.arm_joints],
        )
        joints = tuple(joint.full_identifier for joint in self.joints)
        if parameters.motor is None:
            found = bench.motor_of([alone.joint(name).id for name in joints])
            motor = found and root.find(*found)
        else:
            tendon = robot.gripper_root.find("tendon", escaped_name(parameters.motor))
            motor = tendon or robot.find("joint", parameters.motor)
        first, second = (finger.full_identifier for finger in self.fingers)
        site = robot.tool_site
        self.travel = _limited(
            measure_travel(
                bench,
                FingerNames(joints, (first, second), motor.full_identifier if motor else None),
                tool_body=site.parent.full_identifier,
                T_bt=site_pose(alone, site),
                where=where,
            ),
            parameters,
            where,
        )
        self._moving = [root.find("joint", name) for name in self.travel.joints]
        driven = self.joints if motor is None else [motor]
        efforts = _efforts(alone, self.travel, joints, max_force, together=len(driven) == 1)
        self.actuators = ensure_motors(root, alone, driven, efforts, freed=self._moving)
        if self.travel.one_moves:
            self._stop_at_fixed_finger()

    def _stop_at_fixed_finger(self) -> None:
        """Limit the joint where the fingers meet: MuJoCo ignores parent-child contacts."""
        (joint,), travel = self.joints, self.travel
        ends = travel.positions[:, travel.columns[0]]
        closed = travel.configuration(travel.min_width)[travel.columns[0]]
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
        bases = {id(joint.parent.parent): joint.parent.parent for joint in self.joints}
        self._bases = list(bases.values())
        for joint in _joints_below(self._bases) if given else ():
            joint.set_attributes(**given)

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


def _joints_below(bases: list[Any]) -> list[Any]:
    return [joint for base in bases for joint in base.find_all("joint") if joint.parent is not base]


def _with_joints(
    alone: mujoco.MjModel, bases: list[Any], parameters: TwoFingerParameters
) -> mujoco.MjModel:
    """Return the model with the described armature and dry friction."""
    if parameters.armature is None and parameters.frictionloss is None:
        return alone
    model = copy.copy(alone)
    dofs = [model.jnt_dofadr[model.joint(j.full_identifier).id] for j in _joints_below(bases)]
    if parameters.frictionloss is not None:
        model.dof_frictionloss[dofs] = parameters.frictionloss
    if parameters.armature is not None:
        model.dof_armature[dofs] = parameters.armature
        mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _efforts(
    alone: mujoco.MjModel,
    travel: FingerTravel,
    joints: Sequence[str],
    max_force: float,
    *,
    together: bool,
) -> list[float]:
    """Return the maximum effort of each motor.

    For slides this is the smaller limit of model and description, for other mechanisms that of the
    description: a model's servo gains are no measure of the real force.
    """
    if travel.mass:
        return travel.efforts(max_force, together=together)
    return [min(effort_limit(alone, int(alone.joint(name).id)), max_force) for name in joints]
