"""Quasi-static simulation of a gripper's mechanism over the range of its joints, without load."""

import copy
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import NamedTuple

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.collision import moved_bodies
from bt_manip.robots import RobotError

_SLIDE, _HINGE = int(mujoco.mjtJoint.mjJNT_SLIDE), int(mujoco.mjtJoint.mjJNT_HINGE)
STOPS = 17  # simulated positions of a joint over its range
_STOPS_ALONE = {_SLIDE: 5, _HINGE: 65}  # positions of a joint that moves its finger only
BEHIND = 4e-3  # [m] a finger's surface counts from this distance behind the tool to the tips
_STEPS = 150  # maximum number of simulation steps of 1 ms for each position
_STILL = 2e-3  # [rad/s] or [m/s] below which a joint counts as settled
_POLE = 250.0  # [rad/s] of the loop that moves the joint to each position
_INERTIA = 1e-3  # [kg m2] or [kg] least inertia for which the loop is designed
_HEAVY = 1e4  # [kg m2] armature that freezes a joint; larger values harm the solver's accuracy
_TIGHT = 1e-4  # [m] or [rad] range of a tendon's length up to which it couples its joints

_BADQACC = int(mujoco.mjtWarning.mjWARN_BADQACC)
_ON_JOINT = int(mujoco.mjtTrn.mjTRN_JOINT)
_ON_TENDON = int(mujoco.mjtTrn.mjTRN_TENDON)
_SITE = int(mujoco.mjtWrap.mjWRAP_SITE)
_EQUALITY = mujoco.mjtEq
_COUPLED = {int(_EQUALITY.mjEQ_CONNECT), int(_EQUALITY.mjEQ_WELD)}


class Sweep(NamedTuple):
    """The mechanism at rest at positions of one joint, from its lower to its upper limit.

    Attributes:
        qpos: Positions of all joints of the model.  # (m, nq)
        spring: Spring efforts on all degrees of freedom.  # (m, nv)
        tendons: Lengths of the tendons.  # (m, ntendon)
        bodies: Pose of every body in the world, at each position.
    """

    qpos: np.ndarray
    spring: np.ndarray
    tendons: np.ndarray
    bodies: list[list[pin.SE3]]


class FingerBench:
    """A copy of a robot's model in which only the gripper's joints move.

    The simulation includes closed loops and springs; gravity, contacts, dry friction and actuators
    are disabled.

    Args:
        mj_model: The robot, compiled on its own; it is not changed.

    Attributes:
        model: The copy.
        arm_joints: Full names of the arm's joints, from the base to the tool.
        joints: Ids of the moving joints: the hinges and slides beyond the arm's last link.
        body: Id of the arm's last link.
        bodies: Ids of this link and of all bodies beyond it.
        frictionloss: Dry friction of the degrees of freedom of the model itself.  # (nv,)
    """

    def __init__(self, mj_model: mujoco.MjModel, arm_joints: Sequence[str]) -> None:
        self.model = model = copy.copy(mj_model)
        self.arm_joints = tuple(arm_joints)
        model.opt.timestep = 1e-3
        model.opt.gravity[:] = 0.0
        off = mujoco.mjtDisableBit
        model.opt.disableflags |= int(off.mjDSBL_CONTACT) | int(off.mjDSBL_ACTUATION)
        self.frictionloss = np.array(model.dof_frictionloss)
        model.dof_frictionloss[:] = 0.0
        arm = [int(model.joint(name).id) for name in arm_joints]
        self.body = int(model.jnt_bodyid[arm[-1]])
        self.bodies = np.flatnonzero(moved_bodies(model, model.jnt_dofadr[arm[-1:]])).tolist()
        self.joints = [
            j
            for j in range(model.njnt)
            if j not in arm
            and int(model.jnt_type[j]) in (_SLIDE, _HINGE)
            and int(model.jnt_bodyid[j]) in self.bodies
        ]
        frozen = np.delete(np.arange(model.nv), model.jnt_dofadr[self.joints])
        model.dof_armature[frozen] += _HEAVY
        self._stepped = model

    def sweep(self, joint: int, held: Iterable[int] = ()) -> Sweep:
        """Move a joint from its lower to its upper limit, while others are held."""
        model, data = self.model, mujoco.MjData(self.model)
        driven = [joint, *held]
        targets = data.qpos[model.jnt_qposadr[driven]].copy()
        targets[1:] = np.clip(targets[1:], *model.jnt_range[driven[1:]].T)
        alone = len(self.coupled(joint)) == 1
        qpos, spring, tendons, bodies = [], [], [], []
        lower, upper = (float(limit) for limit in model.jnt_range[joint])
        count = _STOPS_ALONE[int(model.jnt_type[joint])] if alone else STOPS
        for targets[0] in np.linspace(lower, upper, count):
            if alone:
                data.qpos[model.jnt_qposadr[driven]] = targets
                mujoco.mj_fwdPosition(model, data)
                mujoco.mj_passive(model, data)
            else:
                self._go_to(data, driven, targets)
            qpos.append(data.qpos.copy())
            spring.append(data.qfrc_spring.copy())
            tendons.append(data.ten_length.copy())
            bodies.append(body_poses(data))
        diverged = bool(data.warning[_BADQACC].number)
        if diverged and self._stepped is model:
            self._stepped = copy.copy(model)  # light links need more inertia, which moves nothing
            self._stepped.dof_armature[model.jnt_dofadr[self.joints]] += _INERTIA
            return self.sweep(joint, driven[1:])
        return Sweep(np.array(qpos), np.array(spring), np.array(tendons), bodies)

    def _go_to(self, data: mujoco.MjData, joints: Sequence[int], targets: np.ndarray) -> None:
        """Move joints to positions and simulate until the mechanism settles."""
        model = self._stepped
        at_q, at_v = model.jnt_qposadr[joints], model.jnt_dofadr[joints]
        inertia = np.maximum(model.dof_M0[at_v], _INERTIA)
        for i in range(_STEPS):
            pull = _POLE**2 * (targets - data.qpos[at_q]) - 2.0 * _POLE * data.qvel[at_v]
            data.qfrc_applied[at_v] = inertia * pull - data.qfrc_spring[at_v]
            mujoco.mj_step(model, data)
            if i > 20 and np.abs(data.qvel).max() < _STILL:
                break
        mujoco.mj_forward(model, data)

    def coupled(self, joint: int) -> set[int]:
        """Return the joints that an equality, a tendon or a closed loop couples to a joint."""
        groups = list(self._couplings())
        found = {joint}
        while True:
            more = found.union(*(group for group in groups if group & found))
            if more == found:
                return found
            found = more

    def _couplings(self) -> Iterable[set[int]]:
        """List groups of coupled gripper joints."""
        model, ours = self.model, set(self.joints)
        for i in np.flatnonzero(model.eq_active0):
            kind, first, second = (
                int(x) for x in (model.eq_type[i], model.eq_obj1id[i], model.eq_obj2id[i])
            )
            if kind == int(_EQUALITY.mjEQ_JOINT):
                yield {first, second} & ours
            elif kind == int(_EQUALITY.mjEQ_TENDON):
                yield (self.tendon_joints(first) | self.tendon_joints(second)) & ours
            elif kind in _COUPLED:
                if int(model.eq_objtype[i]) == int(mujoco.mjtObj.mjOBJ_SITE):
                    first, second = int(model.site_bodyid[first]), int(model.site_bodyid[second])
                yield (self.chain(first) ^ self.chain(second)) & ours
        for tendon in np.flatnonzero(model.tendon_limited):
            if np.ptp(model.tendon_range[tendon]) < _TIGHT:
                yield self.tendon_joints(int(tendon)) & ours

    def motor_of(self, joints: Sequence[int]) -> tuple[str, str] | None:
        """Return the joint or tendon of the coupled joints' actuator; None if they are independent.

        Returns:
            ``"joint"`` or ``"tendon"``, and its name; the first joint if there is no actuator.
        """
        model, group = self.model, self.coupled(joints[0])
        if joints[-1] not in group:
            return None
        for actuator in range(model.nu):
            if self.moved_by(actuator) & group:
                on_joint = int(model.actuator_trntype[actuator]) == _ON_JOINT
                kind, target = "joint" if on_joint else "tendon", model.actuator_trnid[actuator, 0]
                return kind, getattr(model, kind)(target).name
        return "joint", model.joint(joints[0]).name

    def moved_by(self, actuator: int) -> set[int]:
        """Return the gripper's joints that an actuator moves directly."""
        kind, target = (
            int(x)
            for x in (self.model.actuator_trntype[actuator], self.model.actuator_trnid[actuator, 0])
        )
        if kind == _ON_JOINT:
            return {target} & set(self.joints)
        return self.tendon_joints(target) & set(self.joints) if kind == _ON_TENDON else set()

    def pulling_actuators(self) -> list[int]:
        """List the actuators on spatial tendons that are attached beyond the arm's last link."""
        model, found = self.model, []
        for actuator in np.flatnonzero(model.actuator_trntype == _ON_TENDON).tolist():
            sites = self._wrapped(int(model.actuator_trnid[actuator, 0]), _SITE)
            if {int(model.site_bodyid[site]) for site in sites} & {*self.bodies} - {self.body}:
                found.append(actuator)
        return found

    def tendon_joints(self, tendon: int) -> set[int]:
        """Return the joints of a fixed tendon; none for a spatial one and for -1."""
        return set() if tendon < 0 else self._wrapped(tendon, int(mujoco.mjtWrap.mjWRAP_JOINT))

    def _wrapped(self, tendon: int, kind: int) -> set[int]:
        """Return the joints or sites of a tendon's path."""
        model, first = self.model, int(self.model.tendon_adr[tendon])
        wraps = range(first, first + int(model.tendon_num[tendon]))
        return {int(model.wrap_objid[w]) for w in wraps if int(model.wrap_type[w]) == kind}

    def chain(self, body: int) -> set[int]:
        """Return the gripper's joints between the arm's last link and a body."""
        above = ancestors(self.model, body)
        return {j for j in self.joints if int(self.model.jnt_bodyid[j]) in above}


@contextmanager
def naming(robot: str) -> Iterator[None]:
    """Let errors in the block begin with the name of a robot."""
    try:
        yield
    except RobotError as error:
        raise type(error)(f"{robot}: {error}") from error


def body_poses(data: mujoco.MjData) -> list[pin.SE3]:
    """Return the pose of every body in the world."""
    return [
        pin.SE3(R.reshape(3, 3).copy(), p.copy()) for R, p in zip(data.xmat, data.xpos, strict=True)
    ]


def ancestors(model: mujoco.MjModel, body: int) -> list[int]:
    """List a body and its ancestors, up to the world."""
    found = [body]
    while found[-1]:
        found.append(int(model.body_parentid[found[-1]]))
    return found
