"""Compilation of inverse kinematics problems for an arm."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.cell import literal_name, short_name
from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import did_you_mean, shown
from bt_manip.robots import RobotModel, check_vector, invalid
from bt_manip.spatial import as_numbers

from .problem import IKProblem, Residual
from .residuals import (
    WIDE,
    AxisResidual,
    FrameResidual,
    PoseResidual,
    PositionResidual,
    RotationResidual,
    StackedResidual,
)
from .secondary_objectives import SecondaryObjectives
from .targets import FreeAxisTarget, PoseTarget, PositionTarget, RotationTarget, Target

_FRAMES = (pin.FrameType.OP_FRAME, pin.FrameType.BODY)  # MuJoCo's sites and bodies


class CompiledProblem(NamedTuple):
    """A compiled inverse kinematics problem of one arm.

    Attributes:
        constraints: Residual of the constraints.
        lower: Lower position limits.  # (nq,)
        upper: Upper position limits.  # (nq,)
        joints: Names of the joints.
        frames: Names of the targets' frames, in the order of the request.
        residuals: Residuals of each target.
        objectives: The cost, or None.
        tool_target: Pose of the tool if a constraint fixes it and all joints may move; with free
            rotations, the target in the model's world.
        world: Collision world of solutions, or None.
        clearance: Minimum distance from obstacles [m].
    """

    constraints: StackedResidual
    lower: np.ndarray
    upper: np.ndarray
    joints: tuple[str, ...]
    frames: tuple[str, ...]
    residuals: tuple[tuple[FrameResidual, ...], ...]
    objectives: SecondaryObjectives | None = None
    tool_target: pin.SE3 | PoseTarget | None = None
    world: CollisionWorld | None = None
    clearance: float = 0.0

    def errors(self, q: np.ndarray) -> tuple[Residual, ...]:
        """Return the error of each target at a configuration."""
        self.cost(q)
        return tuple(map(_frame_error, self.frames, self.residuals))

    def cost(self, q: np.ndarray) -> float:
        """Return the cost of a configuration."""
        if self.constraints.q is not q:
            self.constraints.evaluate(q)
        return 0.0 if self.objectives is None else self.objectives.expand(self.constraints).value

    def collision(self, q: np.ndarray) -> str:
        """Name the first collision at a configuration; empty without one."""
        near = [] if self.world is None else self.world.collisions(q, self.clearance)
        return f"'{near[0].first}' would touch '{near[0].second}'" if near else ""


def compile_problem(
    arm: RobotModel,
    joints: tuple[str, ...],
    problem: IKProblem,
    q0: np.ndarray,
    inverse_speed: np.ndarray,
) -> CompiledProblem:
    """Compile a problem for an arm.

    Args:
        arm: The arm; its data are written to.
        joints: Names of its joints.
        problem: The problem.
        q0: Positions of the fixed joints.  # (nq,)
        inverse_speed: Inverse of the maximum joint velocities [s/rad].  # (nq,)

    Raises:
        MotionError: If a frame or a joint is unknown, the margin leaves a joint no range, or the
            collision world is of another arm.
    """
    moving = _moving_joints(joints, problem)
    lower, upper = _limits(arm, joints, problem)
    if moving is not None:
        lower, upper = np.where(moving, lower, q0), np.where(moving, upper, q0)
    T_mw = None  # pose of the targets' world in the model's world
    if problem.base is not None:
        root = arm.model.frames[frame_index(arm, arm.model.name)]
        T_mw = root.placement * problem.base.inverse()
    residuals = tuple(_residuals(arm, target, T_mw) for target in problem.targets)
    constraints: list[FrameResidual] = []
    costs: list[FrameResidual] = []
    tool_target: pin.SE3 | PoseTarget | None = None
    for target, parts in zip(problem.targets, residuals, strict=True):
        (constraints if target.weight is None else costs).extend(parts)
        first = parts[0]
        if first.frame != arm.tool_frame_id or moving is not None or target.weight is not None:
            continue
        if isinstance(first, PoseResidual):
            tool_target = first.pose
        elif isinstance(target, PoseTarget) and target.free_axis is not None:
            pose = target.pose if T_mw is None else T_mw * target.pose
            tool_target = replace(target, pose=pose)
    objectives = None
    if costs or problem.posture is not None or problem.manipulability:
        posture = manipulability = None
        if problem.posture is not None:
            q = check_vector(problem.posture, "posture", "rad", size=arm.nq)
            posture = (q, problem.posture_weight)
        if problem.manipulability:
            manipulability = (arm, moving, problem.manipulability)
        objectives = SecondaryObjectives(
            inverse_speed, residuals=costs, posture=posture, manipulability=manipulability
        )
    if problem.world is not None:
        if problem.world.joints != joints:
            raise invalid(
                f"the CollisionWorld is that of an arm with {', '.join(problem.world.joints)}: "
                f"this one has {', '.join(joints)}"
            )
        problem.world.refresh()
    return CompiledProblem(
        StackedResidual(arm, constraints, moving),
        lower,
        upper,
        joints,
        tuple(target.frame for target in problem.targets),
        residuals,
        objectives,
        tool_target,
        problem.world,
        problem.clearance,
    )


def _frame_error(frame: str, residuals: tuple[FrameResidual, ...]) -> Residual:
    """Combine the errors of one target."""
    positions, rotations, met = zip(*[part.errors() for part in residuals], strict=True)
    return Residual(frame, max(positions), max(rotations), all(met))


def frame_index(arm: RobotModel, name: str) -> int:
    """Return the index of a site or body of the robot; the robot's name as prefix is optional.

    Raises:
        MotionError: If there is no such frame, or several.
    """
    for kind in _FRAMES:
        if arm.model.existFrame(name, kind):
            return int(arm.model.getFrameId(name, kind))
    known = {frame.name: i for i, frame in enumerate(arm.model.frames) if frame.type in _FRAMES}
    found = [i for full, i in known.items() if name in (short_name(full), literal_name(full))]
    if len(found) != 1:
        near = did_you_mean(name, map(literal_name, known))
        raise invalid(f"the arm has no frame '{name}'{near}")
    return found[0]


def _moving_joints(joints: tuple[str, ...], problem: IKProblem) -> np.ndarray | None:
    """Return which joints may move; None for all."""
    if problem.joints is None:
        return None
    full = {literal_name(name): name for name in joints}
    by_name = {short_name(name): name for name in joints} | full
    for name in problem.joints:
        if name not in by_name:
            raise invalid(f"the arm has no joint '{name}'{did_you_mean(name, full)}")
    chosen = {by_name[name] for name in problem.joints}
    if not chosen:
        raise invalid("joints must name at least one joint that may move")
    return None if len(chosen) == len(joints) else np.array([name in chosen for name in joints])


def _limits(
    arm: RobotModel, joints: tuple[str, ...], problem: IKProblem
) -> tuple[np.ndarray, np.ndarray]:
    """Return the position limits inside the margin."""
    limits, margin = arm.limits, as_numbers(problem.margin)
    if margin.size == 1:
        margin = np.full(arm.nq, margin.ravel())
    if margin.shape != (arm.nq,) or not (np.isfinite(margin) & (margin >= 0.0)).all():
        raise invalid(
            f"margin must be at least 0 [rad], one number or {arm.nq}, got {shown(problem.margin)}"
        )
    lower, upper = limits.lower + margin, limits.upper - margin
    if (lower > upper).any():
        i = int(np.flatnonzero(lower > upper)[0])
        unit = arm.units[i]
        raise invalid(
            f"a margin of {margin[i]:g} {unit} leaves {joints[i]} no range: its limits "
            f"are {limits.lower[i]:.4f} to {limits.upper[i]:.4f} {unit}"
        )
    return lower, upper


def _residuals(arm: RobotModel, target: Target, T_mw: pin.SE3 | None) -> tuple[FrameResidual, ...]:
    """Return the residuals of a target given in a world with the pose T_mw in the model's world."""
    frame = frame_index(arm, target.frame)
    position, rotation, accepted = None, None, (0.0, 0.0)
    if target.tolerance is None:
        accepted = arm.tolerance.position, arm.tolerance.rotation
    if isinstance(target, PoseTarget):
        pose = target.pose if T_mw is None else T_mw * target.pose
        narrow = target.weight is None and max(target.tolerances) < WIDE
        if narrow and target.free_axis is None:
            return (PoseResidual(arm, frame, pose, target.tolerances, accepted),)
        position, rotation = pose.act(np.asarray(target.pivot)), pose.rotation
    elif isinstance(target, PositionTarget):
        position = target.position if T_mw is None else T_mw.act(target.position)
    elif isinstance(target, RotationTarget):
        rotation = target.rotation if T_mw is None else T_mw.rotation @ target.rotation
    scale, tolerances = 1.0, target.tolerances
    if target.weight is not None:
        scale, tolerances = target.weight**0.5, (np.inf, np.inf)
    residuals: list[FrameResidual] = []
    if position is not None:
        origin = PositionResidual(arm, frame, position, tolerances[0], scale, accepted[0])
        if isinstance(target, PoseTarget) and np.any(target.pivot):
            origin.pivot = np.asarray(target.pivot)
        residuals.append(origin)
    if isinstance(target, FreeAxisTarget) and target.free_axis is not None:
        axis = np.asarray(target.free_axis)
        if target.cone < np.pi:
            given = axis, tolerances[1], scale, accepted[1]
            residuals.append(AxisResidual(arm, frame, rotation @ axis, *given))
    elif rotation is not None:
        residuals.append(RotationResidual(arm, frame, rotation, tolerances[1], scale, accepted[1]))
    return tuple(residuals)
