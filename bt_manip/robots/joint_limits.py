"""Joint limits of an arm."""

from dataclasses import dataclass, fields

import mujoco
import numpy as np

from bt_manip.cell import escaped_name

from .errors import RobotError
from .model_building import find
from .robot_description import RobotDescription


@dataclass(frozen=True, eq=False)
class JointLimits:
    """Limits of every joint of an arm; the arrays are read-only copies.

    Attributes:
        lower: Minimum position [rad] or [m]; minus infinity if unlimited.  # (nq,)
        upper: Maximum position [rad] or [m]; infinity if unlimited.  # (nq,)
        velocity: Maximum speed [rad/s].  # (nq,)
        acceleration: Maximum acceleration [rad/s2].  # (nq,)
        jerk: Maximum jerk [rad/s3].  # (nq,)
        effort: Maximum torque [N m] or force [N].  # (nq,)
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    effort: np.ndarray

    def __post_init__(self) -> None:
        """Copy, check and freeze the arrays."""
        for field in fields(self):
            array = np.array(getattr(self, field.name), dtype=float)
            array.setflags(write=False)
            object.__setattr__(self, field.name, array)
        for field in fields(self):
            array = getattr(self, field.name)
            if array.shape != self.lower.shape or array.ndim != 1:
                raise RobotError(
                    f"joint limits: one {field.name} a joint, {self.lower.shape} of them, "
                    f"got shape {array.shape}"
                )
            valid = (array > 0.0) & (array < np.inf)
            if field.name not in ("lower", "upper") and not valid.all():
                raise RobotError(
                    f"joint limits: {field.name} must be positive and finite, got {array}"
                )
        if not (self.lower < self.upper).all():
            raise RobotError(f"joint limits: lower {self.lower} not below upper {self.upper}")

    def contain(self, q: np.ndarray, tolerance: float = 0.0) -> bool:
        """Return whether a configuration is inside the position limits."""
        return bool((q >= self.lower - tolerance).all() and (q <= self.upper + tolerance).all())

    def sampling_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return finite position limits to sample within, as the function of this name does."""
        return sampling_bounds(self.lower, self.upper)


def sampling_bounds(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return finite limits to sample within: at most half a turn from zero, pi metres for slides.

    Limits that lie beyond on one side of zero are kept.
    """
    least = np.where(upper < -np.pi, lower, np.maximum(lower, -np.pi))
    most = np.where(lower > np.pi, upper, np.minimum(upper, np.pi))
    return least, most


def read_limits(mj_model: mujoco.MjModel, description: RobotDescription) -> JointLimits:
    """Return the limits of the arm's joints from its model and description.

    Position limits come from the model. Effort limits come from the description, or otherwise from
    the model: the smallest of the force ranges of joint and actuators and of the motors' control
    ranges.

    Args:
        mj_model: The robot's model, compiled on its own.
        description: The robot's description.

    Raises:
        RobotError: If a joint is unknown or its effort is unbounded in both.
    """
    joints = [find(mj_model, "joint", escaped_name(name)) for name in description.arm_joints]
    limited = mj_model.jnt_limited[joints].astype(bool)
    effort = description.effort
    if effort is None:
        effort = tuple(effort_limit(mj_model, joint) for joint in joints)
        unbounded = [
            name
            for name, bound in zip(description.arm_joints, effort, strict=True)
            if not np.isfinite(bound)
        ]
        if unbounded:
            raise RobotError(
                f"{description.where}: neither its model nor its description bounds the "
                f"effort of {', '.join(unbounded)}; give `effort` in the description"
            )
    return JointLimits(
        lower=np.where(limited, mj_model.jnt_range[joints, 0], -np.inf),
        upper=np.where(limited, mj_model.jnt_range[joints, 1], np.inf),
        velocity=np.array(description.velocity),
        acceleration=np.array(description.acceleration),
        jerk=np.array(description.jerk),
        effort=np.array(effort),
    )


def effort_limit(mj_model: mujoco.MjModel, target: int, kind: str = "joint") -> float:
    """Return the maximum effort of the actuators of a target, infinite when unbounded.

    Args:
        mj_model: The model.
        target: Id of a joint or a tendon.
        kind: ``"joint"`` or ``"tendon"``.
    """
    bound = np.inf
    if kind == "joint" and mj_model.jnt_actfrclimited[target]:
        bound = float(np.abs(mj_model.jnt_actfrcrange[target]).min())
    transmission = mujoco.mjtTrn.mjTRN_JOINT if kind == "joint" else mujoco.mjtTrn.mjTRN_TENDON
    moves = mj_model.actuator_trntype == int(transmission)
    for i in np.flatnonzero(moves & (mj_model.actuator_trnid[:, 0] == target)):
        gear = abs(float(mj_model.actuator_gear[i, 0]))
        if mj_model.actuator_forcelimited[i]:
            bound = min(bound, gear * float(np.abs(mj_model.actuator_forcerange[i]).min()))
        if mj_model.actuator_ctrllimited[i] and is_motor(mj_model, int(i)):
            bound = min(bound, gear * float(np.abs(mj_model.actuator_ctrlrange[i]).min()))
    return bound


def is_motor(mj_model: mujoco.MjModel, actuator: int) -> bool:
    """Return whether an actuator's force equals its control signal."""
    return (
        int(mj_model.actuator_gaintype[actuator]) == int(mujoco.mjtGain.mjGAIN_FIXED)
        and int(mj_model.actuator_biastype[actuator]) == int(mujoco.mjtBias.mjBIAS_NONE)
        and int(mj_model.actuator_dyntype[actuator]) == int(mujoco.mjtDyn.mjDYN_NONE)
        and float(mj_model.actuator_gainprm[actuator, 0]) == 1.0
    )
