"""Planning of requested motions: one function of the request, the arm's state and the scene."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain, tee
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import InverseKinematics, Target
from bt_manip.planning import (
    Planner,
    Step,
    blend,
    check_goals,
    check_tool_path,
    collision_free_goals,
    follow_tool_path,
    goal_configurations,
    plan_back_off,
    plan_collision_free_motion,
    tool_paths,
    trajectory_is_free,
)
from bt_manip.robots import MotionLimits, RobotModel
from bt_manip.trajectories import (
    CONTROL_STEP,
    BlendedTrajectory,
    JointTrajectory,
    SequenceTrajectory,
    SplinePath,
    TailTrajectory,
    TimeScaledTrajectory,
    Trajectory,
    at_speed_scale,
    change_speed_scale,
    joint_profiles,
    limit_use,
    plan_stop,
    sample_times,
    scale_to_effort_limits,
    time_parameterize,
    time_parameterize_segment,
    tool_use,
    velocity_profiles,
)

from .follower import ArmState, PlannedMotion

NEAR_TARGET = 0.2  # [rad] between a followed target and where a motion that is kept may end
_AT_TARGET = 1e-10  # [rad] at which no motion is needed; Ruckig fails below 1e-12
STOP_SAMPLES = 20  # configurations of a stop, as the path just travelled
SERVO_SLOWINGS = 4  # of joints near their position limits, or of all for the tool's speed
TURN_SLOWINGS = 8  # attempts to turn within the limit of the tool's speed
TURN_SLOWER = 0.98  # at most, from one to the next
SERVO_SLOWER = 1.001  # times the excess, for rounding
_SLOWEST = 1e-3  # path velocity from which a motion at full speed is inferred


class ConfigurationRequest(NamedTuple):
    """Move the joints to a configuration."""

    q: np.ndarray  # [rad]  (nq,)
    speed: float  # 0 to 1; at 0.5 a motion takes twice the time


class PoseRequest(NamedTuple):
    """Move the joints to the nearest configuration that puts the tool at one of several poses."""

    T_wt: pin.SE3 | Target | Sequence[pin.SE3 | Target]
    speed: float
    margin: float  # [rad] from the joint limits, kept where possible
    approach: float  # [m] straight along the tool's z axis, possible from there if anywhere


class ToolPathRequest(NamedTuple):
    """Move the tool along lines and arcs."""

    steps: Sequence[Step]
    speed: float
    blend: float  # [m] from a corner, where its rounding begins; at 0 the tool stops there
    contact: bool  # whether contact is intended; then collisions are not checked
    joint_path: SplinePath | None = None  # that follows them from its start, if it is known


class FollowRequest(NamedTuple):
    """Turn towards the present pose of a moving target, near the present configuration."""

    T_wt: pin.SE3
    speed: float


class BackOffRequest(NamedTuple):
    """Move back along the path just travelled."""

    travelled: np.ndarray  # [rad] the last configuration first  (n, nq)
    distance: float  # [m] of the tool
    speed: float


class ServoRequest(NamedTuple):
    """Change to a velocity, then come to rest."""

    v: np.ndarray  # [rad/s]  (nq,)
    duration: float  # [s] until this velocity is reached
    contact: bool  # whether contact is intended


Request = (
    ConfigurationRequest
    | PoseRequest
    | ToolPathRequest
    | FollowRequest
    | BackOffRequest
    | ServoRequest
)


def in_sequence(*parts: Trajectory | None) -> Trajectory:
    """Return one trajectory of several parts, of which at least one is not None."""
    given = [part for part in parts if part is not None]
    return given[0] if len(given) == 1 else SequenceTrajectory(given)


class PlanningScene(NamedTuple):
    """The model, solvers and obstacles with which motions are planned.

    Attributes:
        delay: Joins a stop and a motion (None where there is none) with a rest between them, in
            which other arms pass.
    """

    model: RobotModel  # with the payload
    ik: InverseKinematics
    world: CollisionWorld | None  # None checks no collisions
    planner: Planner
    delay: Callable[[Trajectory | None, Trajectory | None], Trajectory] = in_sequence


def plan(
    request: Request, state: ArmState, scene: PlanningScene, rng: np.random.Generator
) -> PlannedMotion | None:
    """Plan a requested motion from the present state to rest; the same arguments, the same bits.

    A motion that replaces one at a lower speed scale is planned from the state that the arm would
    have at full speed, then scaled in time: it takes the same path at any speed scale. Where the
    limits do not allow that, it is planned from the actual state.

    With a blend radius, a motion to a configuration, a pose or along a tool path is planned from
    the end of the present motion, and begins before that one has come to rest where it can.

    Args:
        request: The request.
        state: The present state of the arm.
        scene: Model, solvers and obstacles.
        rng: Random generator of the planner.

    Returns:
        The motion; None when the arm already is at the target, or when its present motion serves a
        `FollowRequest`.

    Raises:
        MotionError: When the target is unreachable or inside an obstacle, when no collision-free
            path is found, or when it exceeds the effort limits.
    """
    free = isinstance(request, ConfigurationRequest | PoseRequest)
    free = free or (isinstance(request, ToolPathRequest) and not request.contact)
    blends = free and state.blend_radius > 0.0
    targets: Iterator[np.ndarray] = iter(())
    if isinstance(request, ToolPathRequest):
        scene = scene._replace(world=None) if request.contact else scene
    elif not isinstance(request, BackOffRequest | ServoRequest):
        targets = _targets(request, _at_end(state) if blends else state, scene)
    arm = scene.model
    for start, s_dot, s_ddot in _starts(state):
        # The tool may be faster in a motion that is executed slower than planned.
        scale = max(s_dot, state.speed_scale) or 1.0
        if arm.limits.limits_tool:
            scene = scene._replace(model=arm.with_limits(arm.limits.at_scale(scale)))
        first = _rest(start) if blends else None
        start = start if first is None else _at_end(start)
        if isinstance(request, ToolPathRequest):
            stop, motion = _plan_tool_path(request, start, scene)
        elif isinstance(request, BackOffRequest):
            stop, motion = _plan_back_off(request, start, scene)
        elif isinstance(request, ServoRequest):
            stop, motion = _plan_servo(request, start, scene.model)
        else:
            targets, wanted = tee(targets)
            stop, motion = _plan_to_configurations(request, wanted, start, scene, rng)
        if stop is None and motion is None:
            return None
        speed_scale = s_dot if motion is None else state.speed_scale
        if first is None or motion is None:
            trajectory = scene.delay(stop, motion)
        else:
            trajectory = _blended(first, motion, state.blend_radius, scene)
        planned = _scaled(trajectory, s_dot, s_ddot, speed_scale, scene.model)
        from_actual = start.trajectory is state.trajectory
        if planned is not None and (from_actual or tool_use(planned.trajectory, arm.limits) <= 1.0):
            return planned._replace(stops=motion is None)
    raise AssertionError("a motion from the actual state can always be scaled")


def _targets(
    request: ConfigurationRequest | PoseRequest | FollowRequest,
    state: ArmState,
    scene: PlanningScene,
) -> Iterator[np.ndarray]:
    """Return the configurations that fulfil a request, the best first, each found when needed."""
    if isinstance(request, ConfigurationRequest):
        return iter([request.q])
    if isinstance(request, FollowRequest):
        found = scene.ik.follow(request.T_wt, state.target)
        if not found.solved:
            found = scene.ik.nearest(request.T_wt, state.target)
        if not found.solved:
            raise MotionError(f"the pose is unreachable: {found.reason}", reason="unreachable")
        return iter([found.q])
    solutions = goal_configurations(
        scene.ik,
        request.T_wt,
        state.q,
        margin=request.margin,
        approach=request.approach,
        world=scene.world,
    )
    best = next(solutions)
    if not best.solved:
        message = f"the pose is unreachable: {best.reason}"
        if best.iterations:
            message += (
                f"; nearest found is {1e3 * best.position_error:.1f} mm and "
                f"{best.rotation_error:.3f} rad away"
            )
        raise MotionError(message, reason="unreachable")
    return chain([best.q], (solution.q for solution in solutions))


def _starts(state: ArmState) -> Iterator[tuple[ArmState, float, float]]:
    """Yield states to plan from: at full speed where one is defined, and the actual one.

    Yields:
        A state, and path velocity [-] and acceleration [1/s] of the arm relative to it.
    """
    trajectory = state.trajectory
    rest = (state.speed_scale, 0.0) if state.at_rest else None
    if isinstance(trajectory, TimeScaledTrajectory) and not state.stopping:
        s, s_dot, s_ddot = trajectory.time_scaling.at(state.time)
        nominal = trajectory.nominal
        if s_dot > _SLOWEST and s < nominal.duration:
            _, v, a = (rows[0] for rows in nominal.sample(np.array([s])))
            full = state._replace(v=v, a=a, trajectory=nominal, time=s)
            yield full, *(rest or (s_dot, s_ddot))
    yield state, *(rest or (1.0, 0.0))


def _rest(state: ArmState) -> Trajectory | None:
    """Return the rest of the present motion; None of an arm at rest."""
    trajectory, t = state.trajectory, state.time
    while isinstance(trajectory, BlendedTrajectory):
        part, time = trajectory.active(t)
        if part is not trajectory.parts[-1]:
            break
        trajectory, t = part, time  # so that blends do not nest
    return None if trajectory is None else TailTrajectory(trajectory, t)


def _at_end(state: ArmState) -> ArmState:
    """Return the state of rest at the end of the present motion."""
    rest = np.zeros_like(state.q)
    return state._replace(q=state.target, v=rest, a=rest, trajectory=None, time=0.0)


def _blended(
    first: Trajectory, second: Trajectory, radius: float, scene: PlanningScene
) -> Trajectory:
    """Return two motions blended, or one after the other where that is not possible."""
    blended = blend(first, second, radius, scene.model, scene.world)
    if blended is not None:
        with suppress(MotionError):  # another arm blocks it
            return scene.delay(None, blended)
    return scene.delay(first, second)


def _scaled(
    trajectory: Trajectory, s_dot: float, s_ddot: float, speed_scale: float, model: RobotModel
) -> PlannedMotion | None:
    """Return a trajectory at a speed scale, from a path velocity; None where that is impossible."""
    if speed_scale == s_dot == 0.0 or (s_dot, s_ddot, speed_scale) == (1.0, 0.0, 1.0):
        return PlannedMotion(trajectory)
    change = change_speed_scale(trajectory, (0.0, s_dot, s_ddot), speed_scale, model)
    if change is not None:
        return PlannedMotion(change.trajectory, lagging=not change.near_optimal)
    if s_ddot != 0.0:
        return None
    unchanged = trajectory if s_dot == 1.0 else at_speed_scale(trajectory, 0.0, s_dot)
    return PlannedMotion(unchanged, lagging=True)


def _plan_to_configurations(
    request: ConfigurationRequest | PoseRequest | FollowRequest,
    targets: Iterator[np.ndarray],
    start: ArmState,
    scene: PlanningScene,
    rng: np.random.Generator,
) -> tuple[Trajectory | None, Trajectory | None]:
    """Plan a motion to one of several configurations.

    From rest the joints move on the straight joint-space segment or a collision-free path. A moving
    arm turns towards the first target in the shortest time in which all joints can arrive
    together; where that exceeds a limit or collides, it stops first. Where only the tool would be
    too fast, slower turns are tried. An arm that follows a target
    keeps a motion that ends near it, so that it does not stop at each request.

    Returns:
        The stop and the motion after it; None where one is not needed.
    """
    world, model, speed = scene.world, scene.model, request.speed
    target = next(targets)
    if world is not None and not collision_free_goals(world, start.q, [target]):
        target, *others = check_goals(world, start.q, [target, *targets])
        targets = iter(others)
    if start.trajectory is not None:
        turn = _turn(start, target, model, speed)
        if turn is not None and (world is None or trajectory_is_free(world, turn, target)):
            return None, turn
        if isinstance(request, FollowRequest) and world and _ends_near(start, target, world):
            return None, None
    stop, q = _stop(start, model)
    if np.abs(target - q).max() < _AT_TARGET:
        return stop, None
    if world is None:
        return stop, time_parameterize_segment(q, target, model, speed)
    return stop, plan_collision_free_motion(
        q, target, targets, world, model, speed, scene.planner, rng
    )


def _turn(
    start: ArmState, target: np.ndarray, model: RobotModel, speed: float
) -> JointTrajectory | None:
    """Return the fastest synchronized motion to a target; None where it exceeds a limit."""
    velocity = speed * model.limits.velocity
    state = start.q, start.v, start.a

    def turn_at(v: np.ndarray, a: np.ndarray, jerk: np.ndarray) -> JointTrajectory:
        return JointTrajectory(joint_profiles(state, target, v, a, jerk))

    for _ in range(TURN_SLOWINGS):
        turn = _within_limits(partial(turn_at, velocity), model)
        use = 0.0 if turn is None else tool_use(turn, model.limits)
        if use <= 1.0:
            return turn
        velocity = velocity * min(TURN_SLOWER, 1.0 / use)
    return None


def _within_limits(
    plan: Callable[[np.ndarray, np.ndarray], JointTrajectory], model: RobotModel
) -> JointTrajectory | None:
    """Return a trajectory, planned with accelerations and jerks, within all limits, or None."""
    limits = model.limits
    try:
        trajectory = scale_to_effort_limits(
            lambda factor: plan(factor * limits.acceleration, factor * limits.jerk), model
        )
    except MotionError:
        return None
    return trajectory if limit_use(trajectory, limits).inside else None


def _plan_servo(
    request: ServoRequest, start: ArmState, model: RobotModel
) -> tuple[Trajectory | None, Trajectory | None]:
    """Plan to change to a velocity; where that exceeds a limit, a moving arm stops."""
    state = start.q, start.v, start.a

    def change_to(v: np.ndarray, *limits: np.ndarray) -> JointTrajectory:
        return JointTrajectory(velocity_profiles(state, v, request.duration, *limits))

    motion = _within_limits(
        lambda *limits: _slowed(lambda v: change_to(v, *limits), request.v, model.limits), model
    )
    if motion is not None and tool_use(motion, model.limits) <= 1.0:
        return None, motion
    return _stop(start, model)[0], None


def _slowed(
    plan: Callable[[np.ndarray], JointTrajectory], v: np.ndarray, limits: MotionLimits
) -> JointTrajectory:
    """Return a change to velocities, lowered where they exceed limits.

    Velocities near the position limits are lowered joint by joint, all where the tool is too fast.
    The number of attempts is bounded; the caller checks the limits.
    """
    trajectory = plan(v)
    for _ in range(0 if limits.uniform and not limits.limits_tool else SERVO_SLOWINGS):
        q, q_dot, _ = trajectory.sample(sample_times(trajectory.duration, CONTROL_STEP))
        use = np.maximum(limits.velocity_use(q, q_dot), tool_use(trajectory, limits))
        if use.max() <= 1.0:
            break
        v = v / np.maximum(1.0, SERVO_SLOWER * use)
        trajectory = plan(v)
    return trajectory


def _ends_near(start: ArmState, target: np.ndarray, world: CollisionWorld) -> bool:
    """Tell whether the present motion ends near a target and is still collision-free."""
    assert start.trajectory is not None
    rest = TailTrajectory(start.trajectory, start.time)
    near = float(np.abs(rest.end - target).max()) <= NEAR_TARGET
    return near and trajectory_is_free(world, rest, rest.end)


def _plan_tool_path(
    request: ToolPathRequest, start: ArmState, scene: PlanningScene
) -> tuple[Trajectory | None, Trajectory | None]:
    """Plan a tool path from where the arm comes to rest; return as `_plan_to_configurations`."""
    model = scene.model
    stop, q = _stop(start, model)
    curves, known = [], request.joint_path
    for path in tool_paths(model.pose(q), request.steps, request.blend):
        if known is not None and np.array_equal(known.knots[0, : model.nq], q):
            curve = known
        else:
            curve = follow_tool_path(scene.ik, q, path)
        if scene.world is not None:
            check_tool_path(scene.world, curve, path)
        curves.append((curve, path.grids))
        q = curve.end
    parts = [time_parameterize(curve, model, request.speed, grids) for curve, grids in curves]
    return stop, in_sequence(*parts) if parts else None


def _plan_back_off(
    request: BackOffRequest, start: ArmState, scene: PlanningScene
) -> tuple[Trajectory | None, Trajectory]:
    """Plan the way back from where the arm comes to rest; return as `_plan_to_configurations`."""
    stop, q = _stop(start, scene.model)
    travelled = request.travelled
    if stop is not None:
        times = np.linspace(stop.duration, 0.0, STOP_SAMPLES)
        travelled = np.concatenate([stop.sample(times)[0], travelled])
    return stop, plan_back_off(
        q, travelled, request.distance, scene.world, scene.model, request.speed
    )


def _stop(start: ArmState, model: RobotModel) -> tuple[Trajectory | None, np.ndarray]:
    """Return the stop of a moving arm, and where it comes to rest."""
    if start.trajectory is None:
        return None, start.q
    stop = plan_stop(start.trajectory, start.time, model)
    return stop, stop.end
