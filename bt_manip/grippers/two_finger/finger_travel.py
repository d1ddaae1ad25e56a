"""Travel of the fingers of a gripper as a function of its joints."""

import copy
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from bt_manip.robots import RobotError

from .parameters import TwoFingerParameters

_TENDON = int(mujoco.mjtObj.mjOBJ_TENDON)
_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)

_STOPS = 17  # measured positions of the joint
_STEPS = 150  # maximum number of simulation steps of 1 ms for each position
_STILL = 2e-3  # [rad/s] or [m/s] below which a joint counts as settled
_POLE = 250.0  # [rad/s] of the loop that moves the joint to each position
_HEAVY = 1e4  # [kg m2] armature that freezes the arm; larger values harm the solver's accuracy
_DEGREE = 5  # of the fitted polynomial
_RESIDUAL = 3e-4  # [m] maximum error of the fitted travel


@dataclass(frozen=True, eq=False)
class FingerTravel:
    """Travel of two symmetric fingers as a function of their joints.

    The distance s of a finger from the centre is half the opening. By the principle of virtual
    work, a force of 1 N at the finger requires an effort of ds/dq at the joint.

    Attributes:
        open_width: Maximum opening [m].
        min_width: Minimum opening [m].
        polynomials: Coefficients of s(q) for each finger, the constant first.  # (2, n)
        ratios: Velocity of each finger's joint per velocity of the motor.  # (2,)
        mass: Effective mass of one finger along s [kg]; 0 to read it from the joint.
        loss: Viscous friction of one finger, along s [N s/m].
        joints: Names of all joints that move with the fingers.
        widths: Openings at which `positions` were measured, increasing [m].  # (m,)
        positions: Positions of the joints at `widths`.  # (m, len(joints))
        columns: Indices of the two finger joints in `joints`.
    """

    open_width: float
    min_width: float
    polynomials: np.ndarray
    ratios: np.ndarray
    mass: float
    loss: float
    joints: tuple[str, ...]
    widths: np.ndarray
    positions: np.ndarray
    columns: tuple[int, ...]

    def configuration(self, width: float) -> np.ndarray:
        """Return the positions of all moving joints at an opening [m]."""  # (len(joints),)
        return np.array([np.interp(width, self.widths, column) for column in self.positions.T])

    def efforts(self, force: float, *, together: bool) -> list[float]:
        """Return the maximum effort of each motor for a force of each finger.

        It includes a margin of 20 % for friction.

        Args:
            force: Force of each finger [N].
            together: Whether one motor moves both.
        """
        steepest = []
        for finger, ratio in enumerate(self.ratios):
            slope = np.polynomial.Polynomial(self.polynomials[finger]).deriv()
            column = self.positions[:, self.columns[finger]]
            steepest.append(1.2 * force * float(np.abs(slope(column) * ratio).max()))
        return [sum(steepest)] if together else steepest


def direct_travel(gripper: TwoFingerParameters, joints: Sequence[str]) -> FingerTravel:
    """Return the travel of fingers on slides, whose positions are distances from the centre."""
    widths = np.array([gripper.min_width, gripper.open_width])
    return FingerTravel(
        open_width=gripper.open_width,
        min_width=gripper.min_width,
        polynomials=np.array([[0.0, 1.0]] * len(joints)),
        ratios=np.ones(len(joints)),
        mass=0.0,
        loss=0.0,
        joints=tuple(joints),
        widths=widths,
        positions=np.repeat(widths[:, None] / len(joints), len(joints), axis=1),
        columns=tuple(range(len(joints))),
    )


def is_direct(
    mj_model: mujoco.MjModel, gripper: TwoFingerParameters, joints: Sequence[str]
) -> bool:
    """Return whether each finger is a slide with its own motor."""
    kinds = [int(mj_model.jnt_type[mj_model.joint(name).id]) for name in joints]
    return gripper.motor is None and all(kind == _SLIDE for kind in kinds)


def measure_travel(
    mj_model: mujoco.MjModel,
    gripper: TwoFingerParameters,
    *,
    joints: Sequence[str],
    fingers: Sequence[str],
    motor: str | None,
    arm_joints: Sequence[str],
    where: str,
) -> FingerTravel:
    """Measure the travel of the fingers by simulating the gripper over its range without load.

    The simulation includes closed loops and springs; gravity, contacts and actuators are disabled
    and the arm is frozen. The opening is the minimum distance between the collision geoms of the
    two fingers.

    Args:
        mj_model: The robot, compiled on its own; it is not changed.
        gripper: Parameters of the gripper.
        joints: Full names of the joints that move the two fingers.
        fingers: Full names of the finger bodies.
        motor: Full name of the joint or tendon moved by a motor for both fingers; None for one
            motor per joint.
        arm_joints: Full names of the arm's joints.
        where: Name of the robot, for messages.

    Raises:
        RobotError: If the joints have no range, do not move the fingers, or move them so that one
            opening has several positions.
    """
    model, data = _bench(mj_model, arm_joints)
    ids = [model.joint(name).id for name in joints]
    unlimited = [n for n, j in zip(joints, ids, strict=True) if not model.jnt_limited[j]]
    if unlimited:
        raise RobotError(f"{where}: gripper joints without a range: {', '.join(unlimited)}")
    frozen = {model.joint(name).id for name in arm_joints}
    moving = [j for j in range(model.njnt) if j not in frozen]
    at_q, at_v = model.jnt_qposadr[moving], model.jnt_dofadr[moving]
    shapes = [_shapes(model, name, where) for name in fingers]
    driven = ids[:1] if motor is not None else ids

    positions, widths, lengths = [], [], []
    for share in np.linspace(0.0, 1.0, _STOPS):
        _go_to(model, data, driven, share)
        positions.append(data.qpos[at_q].copy())
        lengths.append(_length(model, data, motor))
        widths.append(
            min(
                mujoco.mj_geomDistance(model, data, a, b, 1.0, None)
                for a in shapes[0]
                for b in shapes[1]
            )
        )
    order = np.argsort(widths, kind="stable")
    opening, q = np.array(widths)[order], np.array(positions)[order]
    steps = np.diff(np.array(widths))
    if opening[-1] - opening[0] < 1e-3 or not ((steps > 0).all() or (steps < 0).all()):
        raise RobotError(
            f"{where}: joint '{joints[0]}' does not open and close the fingers "
            f"{' and '.join(gripper.fingers)}: their distance goes from {1e3 * widths[0]:.1f} to "
            f"{1e3 * widths[-1]:.1f} mm over its range"
        )
    columns = [moving.index(j) for j in ids]
    polynomials = np.array([_fit(q[:, c], 0.5 * opening, where) for c in columns])
    ratios = np.ones(len(ids))
    if motor is not None:
        ratios = np.array([np.polyfit(np.array(lengths)[order], q[:, c], 1)[0] for c in columns])
    middle = _STOPS // 2
    dq = (q[middle + 1] - q[middle - 1]) / (0.5 * (opening[middle + 1] - opening[middle - 1]))
    data.qpos[at_q] = q[middle]
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    return FingerTravel(
        open_width=min(gripper.open_width, float(opening[-1])),
        min_width=max(gripper.min_width, float(opening[0])),
        polynomials=polynomials,
        ratios=ratios,
        mass=0.5 * float(dq @ full[np.ix_(at_v, at_v)] @ dq),
        loss=0.5 * float(dq @ (mj_model.dof_damping[at_v] * dq)),
        joints=tuple(model.joint(j).name for j in moving),
        widths=opening,
        positions=q,
        columns=tuple(columns),
    )


def _bench(
    mj_model: mujoco.MjModel, arm_joints: Sequence[str]
) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Return a copy of the model in which only the gripper's mechanism moves, and its data."""
    model = copy.copy(mj_model)
    model.opt.timestep = 1e-3
    model.opt.gravity[:] = 0.0
    off = mujoco.mjtDisableBit
    model.opt.disableflags |= int(off.mjDSBL_CONTACT) | int(off.mjDSBL_ACTUATION)
    model.dof_frictionloss[:] = 0.0
    frozen = [model.jnt_dofadr[model.joint(name).id] for name in arm_joints]
    model.dof_armature[frozen] += _HEAVY
    return model, mujoco.MjData(model)


def _go_to(model: mujoco.MjModel, data: mujoco.MjData, joints: Sequence[int], share: float) -> None:
    """Move joints to a fraction of their range and simulate until the mechanism settles."""
    lower, upper = model.jnt_range[joints].T
    target = lower + share * (upper - lower)
    at_q, at_v = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
    for i in range(_STEPS):
        inertia = np.maximum(model.dof_M0[at_v], 1e-3)
        pull = _POLE**2 * (target - data.qpos[at_q]) - 2.0 * _POLE * data.qvel[at_v]
        data.qfrc_applied[at_v] = inertia * pull
        mujoco.mj_step(model, data)
        if i > 20 and np.abs(data.qvel).max() < _STILL:
            break
    mujoco.mj_forward(model, data)


def _length(model: mujoco.MjModel, data: mujoco.MjData, motor: str | None) -> float:
    """Return the position of the joint, or the length of the tendon, that the motor moves."""
    if motor is None:
        return 0.0
    tendon = mujoco.mj_name2id(model, _TENDON, motor)
    if tendon >= 0:
        return float(data.ten_length[tendon])
    return float(data.qpos[model.jnt_qposadr[model.joint(motor).id]])


def _shapes(model: mujoco.MjModel, finger: str, where: str) -> list[int]:
    body = model.body(finger).id
    collides = (model.geom_contype != 0) | (model.geom_conaffinity != 0)
    shapes = [int(g) for g in np.flatnonzero((model.geom_bodyid == body) & collides)]
    if not shapes:
        raise RobotError(f"{where}: finger '{finger}' has no geom that collides")
    return shapes


def _fit(q: np.ndarray, s: np.ndarray, where: str) -> np.ndarray:
    """Fit a polynomial to the travel s(q) of a finger [m]."""
    polynomial = np.polynomial.Polynomial.fit(q, s, _DEGREE).convert()
    residual = float(np.abs(polynomial(q) - s).max())
    if residual > _RESIDUAL:
        raise RobotError(
            f"{where}: the way of a finger is no smooth function of its joint: it differs by "
            f"{1e3 * residual:.2f} mm from a polynomial of degree {_DEGREE}"
        )
    return polynomial.coef
