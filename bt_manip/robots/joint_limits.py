"""Joint limits of an arm."""

from dataclasses import dataclass, fields
from typing import NamedTuple

import mujoco
import numpy as np

from bt_manip.cell import escaped_name

from .errors import RobotError
from .model_building import find
from .robot_description import NEAR_LIMITS, RobotDescription

_AHEAD = 1e-3  # [s] a control step, after which a velocity is still to be inside its limit
_MIN_SHARE = 0.025  # of the velocity limits that is left at the ends of the ranges


class VelocityNearLimits(NamedTuple):
    """Velocity limits that shrink towards the position limits: ``-offset + sqrt(2 a d)``.

    Here a is the deceleration and d the distance from `lower` or `upper`, in the direction of
    motion. Nothing is less than `least`.
    """

    offset: np.ndarray  # [rad/s]  (nq,)
    deceleration: np.ndarray  # [rad/s2]  (nq,)
    lower: np.ndarray  # [rad]  (nq,)
    upper: np.ndarray  # [rad]  (nq,)
    least: np.ndarray  # [rad/s]  (nq,)

    @classmethod
    def described(
        cls,
        description: RobotDescription,
        lower: np.ndarray,
        upper: np.ndarray,
        velocity: np.ndarray,
    ) -> "VelocityNearLimits | None":
        """Return the limits of a description, with its margin; None where it has none.

        Args:
            description: The robot's description.
            lower: Lower position limits of the model [rad].  # (nq,)
            upper: Upper position limits of the model [rad].  # (nq,)
            velocity: Velocity limits with their margin [rad/s].  # (nq,)
        """
        if description.near_offset is None or description.near_deceleration is None:
            return None
        share = 1.0 - description.limit_margin
        offset = share * np.array(description.near_offset)
        a = share * share * np.array(description.near_deceleration)
        # The limit at the position that the velocity leads to within a control step, solved for
        # the velocity: the same formula with a greater offset and a wider range.
        wider = _AHEAD * (offset + 0.5 * a * _AHEAD)
        lower = lower if description.near_lower is None else np.array(description.near_lower)
        upper = upper if description.near_upper is None else np.array(description.near_upper)
        least = _MIN_SHARE * velocity
        return cls(offset + a * _AHEAD, a, lower - wider, upper + wider, least)

    def bounds(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the velocity limits at positions, in the directions of velocities.

        Args:
            q: Positions [rad].  # (..., nq)
            v: Velocities, of which the signs count.  # (..., nq)
        """  # (..., nq)
        distance = np.where(v < 0.0, q - self.lower, self.upper - q)
        bound = np.sqrt(2.0 * self.deceleration * np.maximum(distance, 0.0)) - self.offset
        return np.maximum(bound, self.least)

    def range(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the positions between which the formula gives at least `least`."""
        distance = (self.offset + self.least) ** 2 / (2.0 * self.deceleration)
        return self.lower + distance, self.upper - distance


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
        near: Lower velocity limits near the position limits; None where there are none.
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    effort: np.ndarray
    near: VelocityNearLimits | None = None

    def __post_init__(self) -> None:
        """Copy, check and freeze the arrays."""
        if self.near is not None:
            near = VelocityNearLimits(*(_frozen(array) for array in self.near))
            object.__setattr__(self, "near", near)
        constant = [field for field in fields(self) if field.name != "near"]
        for field in constant:
            array = _frozen(getattr(self, field.name))
            object.__setattr__(self, field.name, array)
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

    def velocity_at(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the velocity limits at positions, in the directions of velocities [rad/s].

        Args:
            q: Positions [rad].  # (..., nq)
            v: Velocities, of which the signs count.  # (..., nq)
        """  # (..., nq), or (nq,) where they do not depend on the positions
        if self.near is None:
            return self.velocity
        return np.minimum(self.velocity, self.near.bounds(q, v))

    def contain(self, q: np.ndarray, tolerance: float = 0.0) -> bool:
        """Return whether a configuration is inside the position limits."""
        return bool((q >= self.lower - tolerance).all() and (q <= self.upper + tolerance).all())

    def sampling_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return finite position limits to sample within, as the function of this name does."""
        return sampling_bounds(self.lower, self.upper)


def _frozen(values: np.ndarray) -> np.ndarray:
    array = np.array(values, dtype=float)
    array.setflags(write=False)
    return array


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
    ranges. Limits of velocity, acceleration and jerk are reduced by the description's margin. Where
    velocity limits shrink to nearly zero before a position limit, this is the position limit.

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
    lower = np.where(limited, mj_model.jnt_range[joints, 0], -np.inf)
    upper = np.where(limited, mj_model.jnt_range[joints, 1], np.inf)
    share = 1.0 - description.limit_margin
    velocity = share * np.array(description.velocity)
    near = VelocityNearLimits.described(description, lower, upper, velocity)
    if near is not None:
        least, most = near.range()
        lower, upper = np.maximum(lower, least), np.minimum(upper, most)
        for name in np.array(description.arm_joints)[lower >= upper].tolist():
            raise RobotError(
                f"{description.where}: [{NEAR_LIMITS}] leaves joint '{name}' no range; give a "
                "smaller 'offset' or a greater 'deceleration'"
            )
    return JointLimits(
        lower=lower,
        upper=upper,
        velocity=velocity,
        acceleration=share * np.array(description.acceleration),
        jerk=share * np.array(description.jerk),
        effort=np.array(effort),
        near=near,
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
