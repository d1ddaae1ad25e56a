"""What a problem means for one arm."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.checks import as_numbers, check_configuration, invalid, shown
from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import MotionError, did_you_mean
from bt_manip.robots import RobotModel

from .manipulability import ToolManipulability
from .problem import IKProblem
from .result import Residual
from .rows import WIDE, PoseRows, PositionRows, RotationRows, Rows
from .secondary_objectives import Posture, SecondaryObjectives
from .system import System
from .targets import PoseTarget, PositionTarget, RotationTarget, Target

_FRAMES = (pin.FrameType.OP_FRAME, pin.FrameType.BODY)  # MuJoCo's sites and bodies


class Task(NamedTuple):
    """What to search for, where, and what is wanted beside it.

    Attributes:
        system: The constraints.
        lower: Limits of the positions.  # (nq,)
        upper: Limits of the positions.  # (nq,)
        joints: Names of the joints.
        frames: The targets' frames, by name, in the order of the request.
        rows: Errors of each target.
        preferences: What costs; None where nothing does.
        tool_pose: Where the tool has to be, where a constraint says so and all joints may move.
        free: What the arm shall not touch.
        clearance: How far from that it shall be [m].
    """

    system: System
    lower: np.ndarray
    upper: np.ndarray
    joints: tuple[str, ...]
    frames: tuple[str, ...]
    rows: tuple[tuple[Rows, ...], ...]
    preferences: SecondaryObjectives | None = None
    tool_pose: pin.SE3 | None = None
    free: CollisionWorld | None = None
    clearance: float = 0.0

    def residuals(self, q: np.ndarray) -> tuple[Residual, ...]:
        """Measure how far each frame is from its target."""
        if self.system.q is not q:
            self.system.look(q)
        if self.preferences is not None:
            self.preferences.measure(self.system)
        if len(self.frames) == 1:
            return (_residual(self.frames[0], self.rows[0]),)
        return tuple(map(_residual, self.frames, self.rows))

    def cost(self, q: np.ndarray) -> float:
        """Give the cost of a configuration."""
        if self.preferences is None:
            return 0.0
        if self.system.q is not q:
            self.system.look(q)
        return self.preferences.measure(self.system)

    def blocked(self, q: np.ndarray) -> str:
        """Say what the arm would touch at a configuration; empty when nothing."""
        near = [] if self.free is None else self.free.collisions(q, self.clearance)
        return f"'{near[0].first}' would touch '{near[0].second}'" if near else ""


def make_task(
    arm: RobotModel,
    joints: tuple[str, ...],
    problem: IKProblem,
    q0: np.ndarray,
    inverse_speed: np.ndarray,
) -> Task:
    """Turn a problem into what a search works with.

    Args:
        arm: The arm; its data are written to.
        joints: Names of its joints.
        problem: What is asked for.
        q0: Where joints stay that may not move.  # (nq,)
        inverse_speed: What a joint's way counts in a distance [s/rad].  # (nq,)

    Raises:
        MotionError: When a frame or a joint is unknown, the margin leaves a joint no room, or what
            the arm shall be free of is the world of another arm.
    """
    moving = _moving(joints, problem)
    lower, upper = _inside(arm, joints, problem)
    if moving is not None:
        lower, upper = np.where(moving, lower, q0), np.where(moving, upper, q0)
    T_mw = _target_world(arm, problem)
    rows = tuple(_rows(arm, target, T_mw) for target in problem.targets)
    constraints: list[Rows] = []
    costs: list[Rows] = []
    tool_pose = None
    for target, made in zip(problem.targets, rows, strict=True):
        (constraints if target.weight is None else costs).extend(made)
        if isinstance(made[0], PoseRows) and made[0].frame == arm.tool_frame_id and moving is None:
            tool_pose = made[0].pose
    preferences = None
    if costs or problem.posture is not None or problem.manipulability:
        posture = None
        if problem.posture is not None:
            try:
                wanted = check_configuration(problem.posture, arm.nq)
            except MotionError as error:
                raise invalid(f"posture: {error}") from None
            posture = Posture(wanted, problem.posture_weight)
        able = (ToolManipulability(arm, moving), problem.manipulability)
        preferences = SecondaryObjectives(
            inverse_speed,
            rows=costs,
            posture=posture,
            manipulability=able if problem.manipulability else None,
        )
    if problem.free is not None:
        if problem.free.joints != joints:
            raise invalid(
                f"the CollisionWorld is that of an arm with {', '.join(problem.free.joints)}: "
                f"this one has {', '.join(joints)}"
            )
        problem.free.refresh()
    system = System(arm, constraints, moving)
    frames = tuple(target.frame for target in problem.targets)
    return Task(
        system,
        lower,
        upper,
        joints,
        frames,
        rows,
        preferences,
        tool_pose,
        problem.free,
        problem.clearance,
    )


def _residual(frame: str, rows: tuple[Rows, ...]) -> Residual:
    """Sum up the errors of one target."""
    if len(rows) == 1:
        return Residual(frame, *rows[0].residual())
    positions, rotations, met = zip(*[row.residual() for row in rows], strict=True)
    return Residual(frame, max(positions), max(rotations), all(met))


def frame_index(arm: RobotModel, name: str) -> int:
    """Find a frame: a site or a body of the robot, with or without the robot's name before it.

    Raises:
        MotionError: When there is none of that name, or several.
    """
    for kind in _FRAMES:
        if arm.model.existFrame(name, kind):
            return int(arm.model.getFrameId(name, kind))
    known = {frame.name: i for i, frame in enumerate(arm.model.frames) if frame.type in _FRAMES}
    short = [i for full, i in known.items() if full.rpartition("/")[2] == name]
    if len(short) != 1:
        raise invalid(f"the arm has no frame '{name}'{did_you_mean(name, known)}")  # fmt: skip
    return short[0]


def _moving(joints: tuple[str, ...], problem: IKProblem) -> np.ndarray | None:
    """Give which joints may move; None where all may."""
    if problem.joints is None:
        return None
    by_name = {name.rpartition("/")[2]: name for name in joints} | {name: name for name in joints}
    for name in problem.joints:
        if name not in by_name:
            raise invalid(f"the arm has no joint '{name}'{did_you_mean(str(name), joints)}")
    chosen = {by_name[name] for name in problem.joints}
    if not chosen:
        raise invalid("joints must name at least one joint that may move")
    return None if len(chosen) == len(joints) else np.array([name in chosen for name in joints])


def _inside(
    arm: RobotModel, joints: tuple[str, ...], problem: IKProblem
) -> tuple[np.ndarray, np.ndarray]:
    limits = arm.limits
    if isinstance(problem.margin, float) and problem.margin == 0.0:
        return limits.lower, limits.upper
    margin = as_numbers(problem.margin)
    if margin.size == 1:
        margin = np.full(arm.nq, margin.ravel())
    if margin.shape != (arm.nq,) or not (np.isfinite(margin) & (margin >= 0.0)).all():
        raise invalid(
            f"margin must be at least 0 [rad], one number or {arm.nq}, got {shown(problem.margin)}"
        )
    lower, upper = limits.lower + margin, limits.upper - margin
    if (lower > upper).any():
        i = int(np.flatnonzero(lower > upper)[0])
        raise invalid(
            f"a margin of {margin[i]:g} rad leaves {joints[i]} no room: its limits "
            f"are {limits.lower[i]:.4f} to {limits.upper[i]:.4f} rad"
        )
    return lower, upper


def _target_world(arm: RobotModel, problem: IKProblem) -> pin.SE3 | None:
    """Give the world of the targets in the world of the model; None where they are the same."""
    if problem.base is None:
        return None
    root = arm.model.frames[frame_index(arm, arm.model.name)]
    return root.placement * problem.base.inverse()


def _rows(arm: RobotModel, target: Target, T_mw: pin.SE3 | None) -> tuple[Rows, ...]:
    frame = frame_index(arm, target.frame)
    place, axes = None, None
    if isinstance(target, PoseTarget):
        pose = target.pose if T_mw is None else T_mw * target.pose
        if target.weight is None and max(target.tolerances) < WIDE:
            return (PoseRows(arm, frame, pose, target.tolerances),)
        place, axes = pose.translation, pose.rotation
    elif isinstance(target, PositionTarget):
        place = target.position if T_mw is None else T_mw.act(target.position)
    elif isinstance(target, RotationTarget):
        axes = target.rotation if T_mw is None else T_mw.rotation @ target.rotation
    scale, tolerances = 1.0, target.tolerances
    if target.weight is not None:
        scale, tolerances = float(target.weight) ** 0.5, (np.inf, np.inf)
    rows: list[Rows] = []
    if place is not None:
        rows.append(PositionRows(arm, frame, place, tolerances[0], scale))
    if axes is not None:
        rows.append(RotationRows(arm, frame, axes, tolerances[1], scale))
    return tuple(rows)
