"""Kinematic and dynamic model of an arm, for planning and control."""

from collections.abc import Sequence
from copy import copy
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin

from .model_building import build_model
from .motion_limits import MotionLimits
from .payload import Payload
from .robot_description import Tolerance

_FRICTION_VELOCITY = 0.01  # [rad/s] at which 76 % of dry friction are compensated, the tanh of 1
_SAMPLES = 1000  # random configurations from which the reach is estimated

_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)


class RobotModel:
    """Kinematics and dynamics of an arm in a world, including its payload.

    The universe frame is MuJoCo's world frame. Methods write into `data`, so every user needs its
    own copy (`copy`).

    Args:
        mj_model: The compiled model.
        joints: Full names of the arm's joints, from the base outwards.
        tool_frame: Full name of the tool's site.
        qpos: Positions at which all other joints are locked.

    Attributes:
        model: Pinocchio's model; its frames are MuJoCo's bodies and sites.
        data: Pinocchio's data.
        units: Unit of each joint's position: ``"rad"``, or ``"m"`` for a slide.
        tool_frame_id: Id of the tool frame.
        limits: Limits of its motions.
        tolerance: Largest errors of the tool pose in inverse kinematics.
        damping: Viscous friction of each joint [N m s/rad].  # (nv,)
        friction: Dry friction of each joint [N m].  # (nv,)
        home: Configuration of the arm at the start [rad].  # (nq,)
        locked_qpos: MuJoCo positions at which all other joints are locked.
        payload: The held payload, or None.
        link_lengths: Distance of each joint from the next one, of the last from the tool, with
            slides at zero [m].  # (nq,)
        levers: Largest distance of the tool from each joint: the sum of the links' lengths between
            them; 1 for a slide, whose effort is a force [m].  # (nq,)

    Raises:
        RobotError: If a name is unknown or the joints do not form an arm.
    """

    def __init__(
        self,
        mj_model: mujoco.MjModel,
        *,
        joints: Sequence[str],
        tool_frame: str,
        limits: MotionLimits,
        home: Sequence[float],
        tolerance: Tolerance,
        qpos: np.ndarray,
    ) -> None:
        self.model = build_model(mj_model, joints=joints, qpos=qpos)
        self.model.lowerPositionLimit = limits.lower
        self.model.upperPositionLimit = limits.upper
        self.locked_qpos = qpos.copy()
        self.data = self.model.createData()
        self.tool_frame_id = self.model.getFrameId(tool_frame, pin.FrameType.OP_FRAME)
        self.limits, self.tolerance = replace(limits, arm=self), tolerance
        dofs = [mj_model.joint(name).dofadr[0] for name in joints]
        slides = mj_model.jnt_type[[mj_model.joint(name).id for name in joints]] == _SLIDE
        self.units = tuple("m" if slide else "rad" for slide in slides)
        self.damping = mj_model.dof_damping[dofs].copy()
        self.friction = mj_model.dof_frictionloss[dofs].copy()
        self.home = np.array(home, dtype=float)
        tool = self.model.frames[self.tool_frame_id]
        self._bare = self.model.inertias[tool.parentJoint].copy()  # of the link with the tool
        self.payload: Payload | None = None
        placements = [*self.model.jointPlacements[2:], tool.placement]
        self.link_lengths = np.array([np.linalg.norm(T.translation) for T in placements])
        self.levers = np.where(slides, 1.0, np.cumsum(self.link_lengths[::-1])[::-1])

    def copy(self) -> "RobotModel":
        """Return a copy with its own `data`."""
        return self.with_payload(self.payload)

    def with_payload(self, payload: Payload | None) -> "RobotModel":
        """Return a copy with this payload at its tool, replacing the current one."""
        other = object.__new__(RobotModel)
        other.__dict__.update(self.__dict__)
        other.model = self.model.copy()
        frame = other.model.frames[self.tool_frame_id]
        joint = frame.parentJoint
        # Start from the bare inertia, so that the result does not depend on earlier payloads.
        other.model.inertias[joint] = self._bare.copy()
        if payload is not None:
            other.model.inertias[joint] = self._bare + frame.placement.act(payload.spatial_inertia)
        other.payload = payload
        other.data = other.model.createData()
        other.limits = replace(self.limits, arm=other)
        return other

    def with_limits(self, limits: MotionLimits) -> "RobotModel":
        """Return a model with other limits of motions, which shares `data`."""
        other = copy(self)
        other.limits = replace(limits, arm=other)
        return other

    @property
    def nq(self) -> int:
        """Number of joints."""
        return int(self.model.nq)

    def pose(self, q: np.ndarray) -> pin.SE3:
        """Return the pose T_wt of the tool in the world."""
        pin.forwardKinematics(self.model, self.data, q)
        return pin.updateFramePlacement(self.model, self.data, self.tool_frame_id)

    def tool_positions(self, q: np.ndarray) -> np.ndarray:
        """Return the positions of the tool in the world [m].

        Args:
            q: Configurations [rad].  # (n, nq)
        """  # (n, 3)
        positions = np.empty((len(q), 3))
        for position, row in zip(positions, q, strict=True):
            position[:] = self.pose(row).translation
        return positions

    def jacobian(self, q: np.ndarray) -> np.ndarray:
        """Return the tool's Jacobian: linear over angular velocity, in world axes."""
        return pin.computeFrameJacobian(  # (6, nv)
            self.model, self.data, q, self.tool_frame_id, pin.LOCAL_WORLD_ALIGNED
        )

    def rnea(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Return the inverse dynamics of links, rotors and payload, without friction."""  # (nv,)
        return pin.rnea(self.model, self.data, q, v, a)

    def effort(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Return the required motor efforts, including viscous and dry friction."""
        tau = pin.rnea(self.model, self.data, q, v, a)
        return tau + self.damping * v + self.friction * np.sign(v)  # (nv,)

    def losses(self, v: np.ndarray) -> np.ndarray:
        """Return the torques against damping and dry friction, with a smooth change of sign.

        Args:
            v: Joint velocities [rad/s].  # (..., nv)
        """  # (..., nv) [N m]
        return self.damping * v + self.friction * np.tanh(v / _FRICTION_VELOCITY)

    @property
    def reach(self) -> float:
        """Largest distance of the tool from the first joint in random configurations [m]."""
        rng, shoulder = np.random.default_rng(0), self.model.jointPlacements[1].translation
        lower, upper = self.limits.sampling_bounds()
        draws = rng.uniform(lower, upper, (_SAMPLES, self.nq))
        return max(float(np.linalg.norm(self.pose(q).translation - shoulder)) for q in draws)

    def static_force(self, q: np.ndarray, direction: np.ndarray) -> float:
        """Return the largest force that the tool exerts at rest within the effort limits [N].

        Args:
            q: Configuration [rad].  # (nq,)
            direction: Of the force on the surroundings, in world axes; unit.  # (3,)
        """
        zero = np.zeros(self.nq)
        tau = self.rnea(q, zero, zero)
        per_newton = self.jacobian(q)[:3].T @ direction
        room = self.limits.effort - np.sign(per_newton) * tau
        loaded = np.abs(per_newton) > 1e-9
        return float(max(min(room[loaded] / np.abs(per_newton[loaded]), default=np.inf), 0.0))
