"""Pinocchio model of an arm, built from the compiled MuJoCo model.

Pinocchio's own MJCF reader silently drops base poses, frames, defaults and gravity. Building the
model from the compiled MuJoCo model makes it agree with the simulation.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import literal_name
from bt_manip.exceptions import did_you_mean

from .errors import RobotError

_FREE = int(mujoco.mjtJoint.mjJNT_FREE)
_BALL = int(mujoco.mjtJoint.mjJNT_BALL)
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


def build_model(
    mj_model: mujoco.MjModel,
    *,
    joints: Sequence[str],
    qpos: np.ndarray | None = None,
) -> pin.Model:
    """Build the Pinocchio model of some joints of a compiled MuJoCo model; all others are locked.

    The universe frame is MuJoCo's world frame, joint positions equal MuJoCo's (also for joints with
    a ``ref``), and joints and frames have their full names in the compiled model.

    Args:
        mj_model: The compiled model.
        joints: Names of the hinge and slide joints that move, from the base outwards.
        qpos: Positions at which the other joints are locked; default: ``mj_model.qpos0``.
            # (mj_model.nq,)

    Raises:
        RobotError: If a joint or body is unknown, of the wrong kind or in the wrong order, or if
            a tendon's armature couples the joints.
    """
    moving = [find_joint(mj_model, name) for name in joints]
    for name, joint in zip(joints, moving, strict=True):
        if int(mj_model.jnt_type[joint]) in (_FREE, _BALL):
            raise RobotError(f"joint '{name}' is free or a ball: an arm has hinges and slides")
    if moving != sorted(set(moving)):
        raise RobotError(
            f"joints in the wrong order: {[literal_name(name) for name in joints]}; the model has "
            f"them as {[literal_name(mj_model.joint(j).name) for j in sorted(set(moving))]}"
        )
    root = int(mj_model.body_rootid[mj_model.jnt_bodyid[moving[0]]])
    qpos = mj_model.qpos0 if qpos is None else np.asarray(qpos, dtype=float)

    model = pin.Model()
    model.name = _name(mj_model.body(root))
    # Placement of each body: its Pinocchio joint, and its pose in that joint's frame.
    placed: dict[int, tuple[int, pin.SE3]] = {0: (0, pin.SE3.Identity())}
    for body in np.flatnonzero(mj_model.body_rootid == root).tolist():
        _add_joints(model, mj_model, body, moving, qpos, placed)
        _add_inertia(model, mj_model, body, placed[body])
        _add_frames(model, mj_model, body, placed[body])

    missing = [n for n, j in zip(joints, moving, strict=True) if not model.existJointName(n)]
    if missing:
        raise RobotError(f"joints {missing} are not below body '{model.name}'")
    dofs = mj_model.jnt_dofadr[moving]
    weightless = mj_model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)
    model.gravity.linear = np.zeros(3) if weightless else mj_model.opt.gravity
    model.armature = mj_model.dof_armature[dofs] + _transmitted_armature(mj_model, moving)
    limited = mj_model.jnt_limited[moving].astype(bool)
    model.lowerPositionLimit = np.where(limited, mj_model.jnt_range[moving, 0], -np.inf)
    model.upperPositionLimit = np.where(limited, mj_model.jnt_range[moving, 1], np.inf)
    return model


def find_joint(mj_model: mujoco.MjModel, name: str) -> int:
    """Return the id of a named joint.

    Raises:
        RobotError: If there is none of that name.
    """
    try:
        return int(mj_model.joint(name).id)
    except KeyError:
        known = [literal_name(mj_model.joint(i).name) for i in range(mj_model.njnt)]
        near = did_you_mean(literal_name(name), known)
        raise RobotError(f"the model has no joint '{literal_name(name)}'{near}") from None


def _name(element: Any) -> str:
    return element.name or f"#{element.id}"


def _translation(p: np.ndarray) -> pin.SE3:
    return pin.SE3(np.eye(3), p)


def _rotation(axis: np.ndarray, angle: float) -> pin.SE3:
    return pin.SE3(pin.exp3(axis * angle), np.zeros(3))


def _add_joints(
    model: pin.Model,
    mj_model: mujoco.MjModel,
    body: int,
    moving: Sequence[int],
    qpos: np.ndarray,
    placed: dict[int, tuple[int, pin.SE3]],
) -> None:
    """Add the moving joints of a body, in the order of mj_kinematics, and store its placement."""
    parent, T = placed[int(mj_model.body_parentid[body])]
    T = T * spatial.pose(mj_model.body_pos[body], mj_model.body_quat[body])
    first = int(mj_model.body_jntadr[body])
    for joint in range(first, first + int(mj_model.body_jntnum[body])):
        kind = int(mj_model.jnt_type[joint])
        anchor = _translation(mj_model.jnt_pos[joint])
        axis = mj_model.jnt_axis[joint]
        address = int(mj_model.jnt_qposadr[joint])
        ref = float(mj_model.qpos0[address])
        if kind == _FREE:
            T = spatial.pose(qpos[address : address + 3], qpos[address + 3 : address + 7])
        elif kind == _BALL:
            turn = spatial.pose(np.zeros(3), qpos[address : address + 4])
            T = T * anchor * turn * anchor.inverse()
        else:
            offset = (0.0 if joint in moving else float(qpos[address])) - ref
            shift = _rotation(axis, offset) if kind == _HINGE else _translation(axis * offset)
            T = T * anchor * shift
            if joint in moving:
                name = _name(mj_model.joint(joint))
                parent = model.addJoint(parent, _joint_model(kind, axis), T, name)
                model.addJointFrame(parent)
                T = pin.SE3.Identity()
            T = T * anchor.inverse()
    placed[body] = (parent, T)


def _joint_model(kind: int, axis: np.ndarray) -> pin.JointModel:
    """Return the joint model of an axis; Pinocchio's axis-aligned models are faster."""
    aligned = (
        (pin.JointModelRX, pin.JointModelRY, pin.JointModelRZ)
        if kind == _HINGE
        else (pin.JointModelPX, pin.JointModelPY, pin.JointModelPZ)
    )
    for make, unit in zip(aligned, np.eye(3), strict=True):
        if np.array_equal(axis, unit):
            return make()
    if kind == _HINGE:
        return pin.JointModelRevoluteUnaligned(axis)
    return pin.JointModelPrismaticUnaligned(axis)


def _add_inertia(
    model: pin.Model, mj_model: mujoco.MjModel, body: int, place: tuple[int, pin.SE3]
) -> None:
    mass = float(mj_model.body_mass[body])
    inertia = mj_model.body_inertia[body]
    if mass == 0.0 and not inertia.any():
        return
    parent, T = place
    principal = pin.Inertia(mass, np.zeros(3), np.diag(inertia))
    T_bi = spatial.pose(mj_model.body_ipos[body], mj_model.body_iquat[body])
    model.appendBodyToJoint(parent, principal, T * T_bi)


def _add_frames(
    model: pin.Model, mj_model: mujoco.MjModel, body: int, place: tuple[int, pin.SE3]
) -> None:
    parent, T = place
    joint_frame = model.getFrameId(model.names[parent], pin.FrameType.JOINT) if parent else 0
    frames = [(_name(mj_model.body(body)), T, pin.FrameType.BODY)]
    for site in np.flatnonzero(mj_model.site_bodyid == body):
        T_bs = spatial.pose(mj_model.site_pos[site], mj_model.site_quat[site])
        frames.append((_name(mj_model.site(site)), T * T_bs, pin.FrameType.OP_FRAME))
    for name, placement, kind in frames:
        model.addFrame(pin.Frame(name, parent, joint_frame, placement, kind))


def _transmitted_armature(mj_model: mujoco.MjModel, moving: Sequence[int]) -> np.ndarray:
    """Return the armature that actuators and tendons add to the joints that they move."""
    added = np.zeros(len(moving))
    order = {joint: i for i, joint in enumerate(moving)}
    on_joint = (int(mujoco.mjtTrn.mjTRN_JOINT), int(mujoco.mjtTrn.mjTRN_JOINTINPARENT))
    for actuator in np.flatnonzero(mj_model.actuator_armature):
        if int(mj_model.actuator_trntype[actuator]) not in on_joint:
            raise RobotError(f"actuator #{actuator} has an armature but is not on a joint")
        joint = int(mj_model.actuator_trnid[actuator, 0])
        if joint in order:
            gear = float(mj_model.actuator_gear[actuator, 0])
            added[order[joint]] += gear**2 * float(mj_model.actuator_armature[actuator])
    for tendon in np.flatnonzero(mj_model.tendon_armature):
        first = int(mj_model.tendon_adr[tendon])
        wraps = range(first, first + int(mj_model.tendon_num[tendon]))
        if any(int(mj_model.wrap_type[w]) != int(mujoco.mjtWrap.mjWRAP_JOINT) for w in wraps):
            raise RobotError(f"tendon #{tendon} has an armature and is spatial: not supported")
        ours = [w for w in wraps if int(mj_model.wrap_objid[w]) in order]
        if len(ours) > 1:
            raise RobotError(f"the armature of tendon #{tendon} couples joints of the arm")
        for w in ours:
            coefficient = float(mj_model.wrap_prm[w])
            joint = int(mj_model.wrap_objid[w])
            added[order[joint]] += coefficient**2 * float(mj_model.tendon_armature[tendon])
    return added
