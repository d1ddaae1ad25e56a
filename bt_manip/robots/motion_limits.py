"""Limits of an arm's motions: one value that all who plan, time, check or send motions ask."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np

from bt_manip.cell import escaped_name

from .checks import POSITION_ROUNDING, invalid
from .errors import RobotError
from .model_building import find_joint
from .motors import effort_limit
from .robot_description import NEAR_LIMITS, RobotDescription, ToolLimits

if TYPE_CHECKING:
    from .robot_model import RobotModel

CONTROL_STEP = 1e-3
"""Time between two setpoints, at which motions are sampled and sent [s]."""

ROUNDING = 1e-6
"""Relative excess of a limit that counts as rounding."""

SETPOINT_TOLERANCE = 5e-3
"""Part of the limits of acceleration and jerk by which differences of setpoints may exceed them."""

BOX_TOLERANCE = 1e-3
"""Distance of the tool outside its box at which setpoints are accepted [m]."""

REFERENCE_TOLERANCE = 0.05
"""Relative excess of a limit that is tolerated when a reference is written."""

TOOL_TOLERANCE = 1e-3
"""Part of the limit of the tool's speed by which setpoints may exceed it."""

JOINT_ARRAYS = ("lower", "upper", "velocity", "acceleration", "jerk", "effort")
_BOX_STEPS = 20
"""Control steps between two checks of the tool's position. A tool that accelerates by 20 m/s2 is
less than 1 mm beside the line between two such positions, which is in the box where both are."""

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

    def bounds(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the velocity limits at positions, in the directions of velocities.

        Args:
            q: Positions [rad].  # (..., nq)
            v: Velocities, of which the signs count.  # (..., nq)
        """  # (..., nq)
        distance = np.where(v < 0.0, q - self.lower, self.upper - q)
        bound = np.sqrt(2.0 * self.deceleration * np.maximum(distance, 0.0)) - self.offset
        return np.maximum(bound, self.least)


class Limited(NamedTuple):
    """Quantities of a motion, one row for each time, and what they are limited to.

    Attributes:
        name: Name of the quantity, with ``{}`` for the number of the column, from 1.
        values: The quantities.  # (n, k)
        limits: The largest magnitudes.  # (n, k) or (k,)
    """

    name: str
    values: np.ndarray
    limits: np.ndarray

    @property
    def use(self) -> float:
        """Largest used fraction of a limit."""
        return float(np.abs(self.values / self.limits).max(initial=0.0))


class LimitUse(NamedTuple):
    """Largest used fraction of each kind of limit, over all joints and steps."""

    position: float
    velocity: float
    acceleration: float
    jerk: float

    @property
    def inside(self) -> bool:
        """Whether no limit is exceeded by more than rounding."""
        return max(self) <= 1.0 + ROUNDING


@dataclass(frozen=True, eq=False)
class MotionLimits:
    """Limits of an arm's motions: of its joints, near the ends of their ranges, and of its tool.

    Planners, time parameterization, the follower and the connection to a real arm ask it. The
    arrays are read-only copies.

    Attributes:
        lower: Minimum position [rad] or [m]; minus infinity if unlimited.  # (nq,)
        upper: Maximum position [rad] or [m]; infinity if unlimited.  # (nq,)
        velocity: Maximum speed [rad/s].  # (nq,)
        acceleration: Maximum acceleration [rad/s2].  # (nq,)
        jerk: Maximum jerk [rad/s3].  # (nq,)
        effort: Maximum torque [N m] or force [N].  # (nq,)
        near: Lower velocity limits near the position limits; None where there are none.
        tool: Limits of the tool's motion along and about a line.
        box: Lowest and highest position of the tool in the world [m]; None: anywhere.  # (2, 3)
        tool_speed: Maximum speed of the tool's origin in all motions [m/s].
        arm: The model whose limits they are; without it, those of the tool are not checked.
    """

    lower: np.ndarray
    upper: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    jerk: np.ndarray
    effort: np.ndarray
    near: VelocityNearLimits | None = None
    tool: ToolLimits = ToolLimits()
    box: np.ndarray | None = None
    tool_speed: float = np.inf
    arm: "RobotModel | None" = None

    def __post_init__(self) -> None:
        """Copy, check and freeze the arrays."""
        if self.near is not None:
            near = VelocityNearLimits(*(_frozen(array) for array in self.near))
            object.__setattr__(self, "near", near)
        for name in JOINT_ARRAYS:
            array = _frozen(getattr(self, name))
            object.__setattr__(self, name, array)
            if array.shape != self.lower.shape or array.ndim != 1:
                raise RobotError(
                    f"joint limits: one {name} a joint, {self.lower.shape} of them, "
                    f"got shape {array.shape}"
                )
            valid = (array > 0.0) & (array < np.inf)
            if name not in ("lower", "upper") and not valid.all():
                raise RobotError(f"joint limits: {name} must be positive and finite, got {array}")
        if not (self.lower < self.upper).all():
            raise RobotError(f"joint limits: lower {self.lower} not below upper {self.upper}")

    # Configurations

    def contain(self, q: np.ndarray, tolerance: float = 0.0) -> bool:
        """Return whether a configuration is inside the position limits."""
        return bool((q >= self.lower - tolerance).all() and (q <= self.upper + tolerance).all())

    def checked(self, q: np.ndarray, units: Sequence[str] = ()) -> np.ndarray:
        """Return a configuration, clipped where it exceeds a position limit by rounding only.

        Args:
            q: The configuration [rad].  # (nq,)
            units: Unit of each joint, for messages; by default radians.

        Raises:
            MotionError: When it is outside the limits, naming the first such joint.
        """
        lower, upper = self.lower, self.upper
        outside = ~((q >= lower - POSITION_ROUNDING) & (q <= upper + POSITION_ROUNDING))
        if outside.any():
            i = int(outside.argmax())
            unit = units[i] if units else "rad"
            raise invalid(
                f"joint {i + 1} cannot go to {q[i]:.4f} {unit}: its limits are "
                f"{lower[i]:.4f} to {upper[i]:.4f} {unit}"
            )
        return np.clip(q, lower, upper)

    def sampling_bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return finite position limits to sample within, as the function of this name does."""
        return sampling_bounds(self.lower, self.upper)

    def leaving(self, q: np.ndarray, tolerance: float = POSITION_ROUNDING) -> str:
        """Return which joint leaves its range in a motion, or how the tool leaves its box.

        They may stay as far outside as they are at first.

        Args:
            q: Configurations at the control steps [rad].  # (n, nq)
            tolerance: Distance of the tool outside its box that is accepted [m].

        Returns:
            The problem; empty if there is none.
        """
        found = _first_beyond(q, self.lower, self.upper, POSITION_ROUNDING)
        if found is not None:
            step, joint = found
            low, high = self.lower[joint], self.upper[joint]
            where = f"position of joint {joint + 1} is {q[step, joint]:.4f}"
            return f"{where}, its limits are {low:.4f} to {high:.4f}"
        if self.box is None or self.arm is None:
            return ""
        p = self.arm.tool_positions(np.concatenate([q[:-1:_BOX_STEPS], q[-1:]]))
        found = _first_beyond(p, self.box[0], self.box[1], tolerance)
        if found is None:
            return ""
        step, axis = found
        low, high = self.box[:, axis]
        where = f"{'xyz'[axis]} of the tool is {p[step, axis]:.3f} m"
        return f"{where}, its bounds are {low:g} to {high:g} m"

    # Velocities

    @property
    def uniform(self) -> bool:
        """Whether the velocity limits are the same in all configurations."""
        return self.near is None

    def velocity_at(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the velocity limits of the joints, in the directions of velocities [rad/s].

        Args:
            q: Positions [rad].  # (..., nq)
            v: Velocities, of which the signs count.  # (..., nq)
        """  # (..., nq), or (nq,) where they do not depend on the positions
        if self.near is None:
            return self.velocity
        return np.minimum(self.velocity, self.near.bounds(q, v))

    def speeds(self, q: np.ndarray, v: np.ndarray) -> list[Limited]:
        """Return all that velocity limits bound; the values are proportional to the velocities.

        The first are those of the joints. With the slopes of a path in place of velocities, they
        limit its path velocity.

        Args:
            q: Positions [rad].  # (n, nq)
            v: Velocities [rad/s], or slopes of a path [rad].  # (n, nq)
        """
        return [Limited("velocity of joint {}", v, self.velocity_at(q, v))]

    def velocity_use(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the largest used fraction of the velocity limits that concern each joint."""
        joints, *others = self.speeds(q, v)
        use = np.abs(joints.values / joints.limits).max(axis=0)
        return np.maximum(use, max((limited.use for limited in others), default=0.0))

    # The speed of the tool

    @property
    def limits_tool(self) -> bool:
        """Whether the speed of the tool is limited in all motions."""
        return self.arm is not None and self.tool_speed < np.inf

    def at_scale(self, scale: float) -> "MotionLimits":
        """Return the limits of a motion that keeps these when it is slowed to a speed scale.

        Velocities of joints are not scaled: only the tool may be faster.
        """
        return replace(self, tool_speed=self.tool_speed / scale) if self.limits_tool else self

    def tool_use(self, q: np.ndarray, dt: float) -> np.ndarray:
        """Return the used fractions of the tool's speed limit; 0 without one.

        Args:
            q: Configurations at equal steps of time [rad].  # (n, nq)
            dt: Time between two of them [s].
        """  # (n - 1,)
        if self.arm is None or not self.limits_tool:
            return np.zeros(len(q) - 1)
        steps = np.linalg.norm(np.diff(self.arm.tool_positions(q), axis=0), axis=1)
        return np.asarray(steps / (dt * self.tool_speed))

    # Motions sampled at control steps

    def use(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> LimitUse:
        """Return the used fractions of the limits by n samples at control steps.

        The jerk is the difference of accelerations per step, and a jump of the position is a
        velocity.

        Args:
            q: Positions [rad].  # (n, nq)
            v: Velocities [rad/s].  # (n, nq)
            a: Accelerations [rad/s2].  # (n, nq)
        """
        bounded = np.isfinite(self.upper - self.lower)
        lower, upper = self.lower[bounded], self.upper[bounded]
        moved = np.diff(q, axis=0) / CONTROL_STEP
        return LimitUse(
            Limited("", q[:, bounded] - 0.5 * (upper + lower), 0.5 * (upper - lower)).use,
            max(limited.use for limited in (*self.speeds(q, v), *self.speeds(q[:-1], moved))),
            Limited("", a, self.acceleration).use,
            Limited("", np.diff(a, axis=0) / CONTROL_STEP, self.jerk).use,
        )

    def setpoints_problem(self, before: np.ndarray, setpoints: np.ndarray) -> str:
        """Return which limit setpoints at control steps exceed, by their differences.

        Args:
            before: The setpoints before them [rad].  # (3, nq)
            setpoints: Positions that end at rest [rad].  # (n, nq)

        Returns:
            The problem; empty if there is none.
        """
        if setpoints.ndim != 2 or setpoints.shape[1] != len(self.lower) or not len(setpoints):
            return f"setpoints of shape {setpoints.shape}"
        if not np.isfinite(setpoints).all():
            return "a setpoint is not finite"
        q = np.concatenate([before, setpoints, np.repeat(setpoints[-1:], 3, axis=0)])
        v = np.diff(q, axis=0) / CONTROL_STEP
        a, j = np.diff(v, axis=0) / CONTROL_STEP, np.diff(v, n=2, axis=0) / CONTROL_STEP**2
        checks = [
            *((limited, 1e-4, 1e-6) for limited in self.speeds(q[:-1], v)),
            (Limited("acceleration of joint {}", a, self.acceleration), SETPOINT_TOLERANCE, 1e-4),
            (Limited("jerk of joint {}", j, self.jerk), SETPOINT_TOLERANCE, 0.1),
        ]
        for (name, values, limits), relative, absolute in checks:
            exceeded = np.abs(values) > limits * (1.0 + relative) + absolute
            if exceeded.any():
                step, column = (int(i) for i in np.argwhere(exceeded)[0])
                joins = "where it joins the present one" if step < 3 else f"in setpoint {step - 3}"
                return f"{name.format(column + 1)} {joins}"
        use = self.tool_use(q[2::_BOX_STEPS], _BOX_STEPS * CONTROL_STEP).max(initial=0.0)
        if use > 1.0 + TOOL_TOLERANCE:
            return f"speed of the tool, {use * self.tool_speed:.3f} m/s"
        return self.leaving(np.concatenate([before[-1:], setpoints]), BOX_TOLERANCE)

    def reference_problem(self, q: np.ndarray, times: tuple[float, float]) -> str:
        """Return which limit the last of three references exceeds, by their differences.

        Args:
            q: The references, one after the other [rad].  # (3, nq)
            times: Times between them [s].

        Returns:
            The problem; empty if there is none.
        """
        v_before, v = np.diff(q, axis=0) / np.array(times)[:, None]
        a = (v - v_before) / (0.5 * sum(times))
        for name, values, limits in (
            ("velocity", v, self.velocity),
            ("acceleration", a, self.acceleration),
        ):
            exceeded = np.abs(values) > limits * (1.0 + REFERENCE_TOLERANCE) + 1e-3
            if exceeded.any():
                joint = int(exceeded.argmax())
                return f"{name} of joint {joint + 1}: {values[joint]:.3g}"
        (use,) = self.tool_use(q[1:], times[1])
        return "" if use <= 1.0 + REFERENCE_TOLERANCE else "speed of the tool"

    def get_state(self) -> dict[str, Any]:
        """Return the limits of the joints as plain data, from which they can be built again."""
        state = {name: getattr(self, name).tolist() for name in JOINT_ARRAYS}
        return state if self.near is None else {**state, "near": np.array(self.near).tolist()}


JointLimits = MotionLimits
"""Former name of `MotionLimits`, for one release."""


def _first_beyond(
    values: np.ndarray, lower: np.ndarray, upper: np.ndarray, tolerance: float
) -> tuple[int, int] | None:
    """Return row and column of the first value further outside a range than in the first row."""
    outside = np.maximum(lower - values, values - upper)
    beyond = outside > np.maximum(outside[0], 0.0) + tolerance
    if not beyond.any():
        return None
    row, column = np.argwhere(beyond)[0]
    return int(row), int(column)


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


def read_limits(mj_model: mujoco.MjModel, description: RobotDescription) -> MotionLimits:
    """Return the limits of an arm's motions from its model and description.

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
    joints = [find_joint(mj_model, escaped_name(name)) for name in description.arm_joints]
    limited = mj_model.jnt_limited[joints].astype(bool)
    lower = np.where(limited, mj_model.jnt_range[joints, 0], -np.inf)
    upper = np.where(limited, mj_model.jnt_range[joints, 1], np.inf)
    share = 1.0 - description.limit_margin
    velocity = share * np.array(description.velocity)
    near = None
    if description.near_offset is not None and description.near_deceleration is not None:
        offset = share * np.array(description.near_offset)
        a = share * share * np.array(description.near_deceleration)
        # The limit at the position that the velocity leads to within a control step, solved for
        # the velocity: the same formula with a greater offset and a wider range.
        wider = CONTROL_STEP * (offset + 0.5 * a * CONTROL_STEP)
        low = lower if description.near_lower is None else np.array(description.near_lower)
        high = upper if description.near_upper is None else np.array(description.near_upper)
        offset, least = offset + a * CONTROL_STEP, _MIN_SHARE * velocity
        near = VelocityNearLimits(offset, a, low - wider, high + wider, least)
        distance = (offset + least) ** 2 / (2.0 * a)  # where the formula gives `least`
        lower = np.maximum(lower, near.lower + distance)
        upper = np.minimum(upper, near.upper - distance)
        for name in np.array(description.arm_joints)[lower >= upper].tolist():
            raise RobotError(
                f"{description.where}: [{NEAR_LIMITS}] leaves joint '{name}' no range; give a "
                "smaller 'offset' or a greater 'deceleration'"
            )
    return MotionLimits(
        lower=lower,
        upper=upper,
        velocity=velocity,
        acceleration=share * np.array(description.acceleration),
        jerk=share * np.array(description.jerk),
        effort=_efforts(mj_model, joints, description),
        near=near,
        tool=description.tool_limits,
        tool_speed=np.inf if description.tool_speed is None else description.tool_speed,
    )


def _efforts(
    mj_model: mujoco.MjModel, joints: list[int], description: RobotDescription
) -> np.ndarray:
    """Return the effort limits of joints by id: those of the description, or of the model."""
    if description.effort is not None:
        return np.array(description.effort)
    effort = np.array([effort_limit(mj_model, joint) for joint in joints])
    unbounded = np.array(description.arm_joints)[~np.isfinite(effort)].tolist()
    if unbounded:
        raise RobotError(
            f"{description.where}: neither its model nor its description bounds the "
            f"effort of {', '.join(unbounded)}; give `effort` in the description"
        )
    return effort
