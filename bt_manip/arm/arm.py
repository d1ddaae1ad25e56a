"""The arm as behaviours and scripts command it."""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import InverseKinematics, Target
from bt_manip.planning import MAX_BLEND, LineTo, Planner, RRTConnect, Step, tool_distance
from bt_manip.robots import (
    ArmConnection,
    DeviceError,
    LateError,
    Payload,
    Robot,
    RobotModel,
    check_configuration,
    check_generator,
    check_non_negative,
    check_number,
    check_pose,
    check_positive,
    check_speed,
    check_vector,
)
from bt_manip.trajectories import SplinePath, Trajectory

from .diagnosis import diagnose
from .external_force_guard import CHECK_INTERVAL, Detection, ExternalForceGuard, external_load
from .follower import TrajectoryFollower
from .motion_planning import (
    BackOffRequest,
    ConfigurationRequest,
    FollowRequest,
    PlanningScene,
    PoseRequest,
    Request,
    ServoRequest,
    ToolPathRequest,
    in_sequence,
    plan,
)

if TYPE_CHECKING:
    from .coordination import MultiArmCoordinator

MARGIN = 0.05  # [rad] from the joint limits that chosen configurations keep where possible
MAX_REST_JOINT_SPEED = 0.02  # [rad/s] of a measured joint that counts as at rest
MAX_TRACKING_ERROR = 0.1  # [rad]; an external force is detected at about 0.01 rad
RECOVERY_TIMEOUT = 1.0  # [s] in which joints come to rest after a compliant stop; usually 0.2
SERVO_VELOCITY = 0.98  # of the velocity limits, for rounding
SERVO_ACCELERATION = 0.7  # of the limits, with which it plans to brake: the rest is for the jerk
AHEAD_SAMPLES = 8  # configurations of the rest of a motion whose tool poses are compared
PLANNING_LATENCY = 60  # control steps from a request until a real arm follows the planned motion
STOPPING_LATENCY = 15  # the same of a stop, which is planned in about 4 ms
SEND_ATTEMPTS = 5  # to plan a change for a real arm in time, each with twice the latency
RETRY_INTERVAL = 20  # control steps after which a change of the speed scale is tried again


class Arm:
    """Plan requested motions and move the reference of a controller along them.

    A request is planned as a whole, inside all limits, from the present reference position,
    velocity and acceleration; a new request replaces the motion before it. A request that cannot be
    fulfilled raises `MotionError` and changes nothing. `advance` moves the reference along the
    motion, which can be slowed down, paused and stopped at any time, and which stops by itself on
    an external force.

    Args:
        robot: A compiled robot.
        model: Its model; by default made from the robot.
        ik: Its inverse kinematics; by default made from the model.
        world: Its collision world; by default no collisions are checked.
        planner: Finds collision-free paths; by default `RRTConnect`.
        guard: Detects external forces; by default none are detected.

    Attributes:
        follower: Owns the reference and the trajectory that it follows.
        coordinator: Coordinates it with other arms; None where there are none.
        fault: Why the arm stopped by itself, empty when it did not; the next motion clears it.
        compliant: Whether controllers yield to contact: after a compliant stop, until the next
            motion.
        blend_radius: Radius around the tool's target within which the next motion may begin before
            this one has come to rest [m]; then it is planned from the target. At 0 it replaces this
            one at once. The next motion, a stop and a reset set it to 0.
        connection: Sends the reference to a real arm; None in simulation. With a connection,
            changes of the motion take effect some control steps later, and there are no compliant
            stops.
        speed_factor: Factor of all speed scales, for a whole run.
        q: Reference position [rad], read-only and live.  # (nq,)
        v: Reference velocity [rad/s], read-only and live.  # (nq,)
        a: Reference acceleration [rad/s2], read-only and live.  # (nq,)
    """

    def __init__(
        self,
        robot: Robot,
        *,
        model: RobotModel | None = None,
        ik: InverseKinematics | None = None,
        world: CollisionWorld | None = None,
        planner: Planner | None = None,
        guard: ExternalForceGuard | None = None,
    ) -> None:
        self.robot, self.world, self.guard = robot, world, guard
        self.model = robot.make_model() if model is None else model
        self.ik = InverseKinematics(self.model) if ik is None else ik
        self.planner = RRTConnect() if planner is None else planner
        self.coordinator: MultiArmCoordinator | None = None
        self.fault, self._guarded = "", False
        self.compliant = self._recovering = False
        self.blend_radius = 0.0
        self._settling = 0  # control steps at rest in a compliant stop
        self._unchecked = 0  # control steps since external forces were checked
        self.connection: ArmConnection | None = None
        self.speed_factor = 1.0
        self.follower = TrajectoryFollower(robot.q)
        self.q, self.v, self.a = self.follower.q, self.follower.v, self.follower.a

    def reset(self, q: np.ndarray | None = None) -> None:
        """Discard all motion and rest at a configuration [rad], by default the robot's."""
        self.compliant = self._recovering = False
        self.blend_radius = 0.0
        self._limit_tool(np.inf)
        self.follower.reset(self.robot.q if q is None else q)
        self.follower.speed_scale = self.speed_factor

    def hold_at(self, q: np.ndarray) -> None:
        """Rest at a measured configuration [rad]; ignored while busy.

        Called when another controller takes over: it starts without a position error.
        """
        if not self.busy and self.connection is None:
            self.follower.hold_at(q)

    # Requests

    def move_to_configuration(
        self,
        q: Sequence[float] | np.ndarray,
        speed: float = 1.0,
        *,
        planner: Planner | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Move the joints to a configuration, on the straight joint-space segment if it is free.

        Args:
            q: The target [rad].  # (nq,)
            speed: 1 is as fast as the limits allow; a move from rest at 0.5 takes twice the time.
            planner: Finds a collision-free path otherwise; by default the arm's own planner.
            rng: Its random generator; by default a new one, so that the same request has the same
                result.

        Raises:
            MotionError: When the target is invalid, outside the limits or inside an obstacle, when
                no path is found, or the motion exceeds the effort limits.
        """
        speed = check_speed(speed)
        target = check_configuration(q, self.model.nq)
        target = self.model.limits.checked(target, self.model.units)
        self._move(ConfigurationRequest(target, speed), planner=planner, rng=rng)

    def move_to_pose(
        self,
        T_wt: pin.SE3 | Target | Sequence[pin.SE3 | Target],
        speed: float = 1.0,
        *,
        margin: float = MARGIN,
        approach: float = 0.0,
        planner: Planner | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Move the joints to the nearest configuration that puts the tool at a pose.

        Args:
            T_wt: Pose of the tool in the world, or several equivalent ones; with free rotations,
                a `PoseTarget` or `PositionTarget` of the frame ``arm.ik.tool``.
            speed: As for `move_to_configuration`.
            margin: Distance from the joint limits to keep where possible [rad].
            approach: Length of a straight approach along the tool's z axis that shall be possible
                from there [m], where a configuration allows it.
            planner: As for `move_to_configuration`.
            rng: As for `move_to_configuration`.

        Raises:
            MotionError: When no pose is reachable or all are inside obstacles, when no path is
                found, or the motion exceeds the effort limits.
        """
        speed = check_speed(speed)
        margin = check_non_negative(margin, "margin from the joint limits", "rad")
        approach = check_non_negative(approach, "length of the approach", "m")
        self._move(PoseRequest(T_wt, speed, margin, approach), planner=planner, rng=rng)

    def move_linear(
        self,
        T_wt: pin.SE3 | Target,
        speed: float = 1.0,
        *,
        contact: bool = False,
        joint_path: SplinePath | None = None,
    ) -> None:
        """Move the tool to a pose on a straight line, rotating uniformly.

        A moving arm stops first.

        Args:
            T_wt: Pose of the tool in the world; of a target with free rotations, the pose that the
                arm reaches with the smallest motion.
            speed: 1 is as fast as joints and tool may; at 0.5 it takes twice the time.
            contact: Whether contact is intended; then neither collisions nor external forces are
                checked.
            joint_path: What `follow_tool_path` returned for this line, if that is known; not used
                where the arm does not rest at its start.

        Raises:
            MotionError: When the line cannot be followed to its end (the message says how far),
                collides, or exceeds the effort limits.
        """
        if isinstance(T_wt, Target):
            found = self.ik.nearest(T_wt, self.target, margin=MARGIN)
            if not found.solved:
                raise MotionError(f"the pose is unreachable: {found.reason}", reason="unreachable")
            T_wt = self.model.pose(found.q)
        speed = check_speed(speed)
        self._move(ToolPathRequest([LineTo(T_wt)], speed, 0.0, contact, joint_path))

    def move_path(
        self,
        steps: Sequence[Step],
        speed: float = 1.0,
        *,
        blend: float = 0.0,
        contact: bool = False,
    ) -> None:
        """Move the tool along lines and arcs, without a stop at rounded corners.

        A moving arm stops first.

        Args:
            steps: `LineTo`, `ArcTo` and `TurnAbout`, in their order.
            speed: As for `move_linear`.
            blend: Distance from a corner at which its rounding begins [m]; at 0 the tool stops
                there.
            contact: As for `move_linear`.

        Raises:
            MotionError: When the path cannot be followed to its end (the message and `fraction`
                say how far), collides, or exceeds the effort limits.
        """
        self._move(ToolPathRequest(steps, check_speed(speed), blend, contact))

    def follow(self, T_wt: pin.SE3, speed: float = 1.0) -> None:
        """Turn towards a moving target; to be called again whenever it has moved.

        The arm continues from its present motion, stays near its present configuration, and comes
        to rest at the target if this is not called again.

        Args:
            T_wt: Present pose of the target for the tool in the world.
            speed: 1 is as fast as the limits allow.

        Raises:
            MotionError: When the pose is unreachable or inside an obstacle.
        """
        speed = check_speed(speed)
        self._move(FollowRequest(check_pose(T_wt), speed))

    def servo(
        self, q: np.ndarray, v: np.ndarray, duration: float, *, contact: bool = False
    ) -> None:
        """Move towards a target that moves; to be called again with the next one.

        The arm continues from its present motion. Targets on a smooth motion inside the limits are
        passed in time, others approached as fast as the limits allow. The arm comes to rest when
        this is not called again after the duration. Collisions are not checked. Where the limits
        allow no such motion, the arm stops.

        Args:
            q: Configuration of the target after the duration [rad]; positions beyond the joint
                limits are clipped.  # (nq,)
            v: Its velocity then [rad/s].  # (nq,)
            duration: Time until then [s].
            contact: Whether contact is intended; then external forces are not checked.

        Raises:
            MotionError: When a number is not finite, or the arm cannot move now.
        """
        limits = self.model.limits
        a = SERVO_ACCELERATION * limits.acceleration
        duration = check_positive(duration, "duration", "s")
        q = check_configuration(q, self.model.nq).clip(limits.lower, limits.upper)
        v = check_vector(v, "velocity", "rad/s", size=self.model.nq)
        # By a change of velocity that is linear in time the target would be missed by:
        missed = q - self.q - 0.5 * duration * (self.v + v)
        most = np.sqrt(2.0 * a * np.abs(missed))  # from which the arm can still brake
        v = v + (missed / duration).clip(-most, most)
        room = np.where(v < 0.0, self.q - limits.lower, limits.upper - self.q)
        room -= duration * np.maximum(self.v * np.sign(v), 0.0)
        most = np.minimum(SERVO_VELOCITY * limits.velocity, np.sqrt(a * room.clip(0.0)))
        self._move(ServoRequest(v.clip(-most, most), duration, contact))

    def back_off(self, distance: float, speed: float = 1.0) -> None:
        """Move back along the path just travelled.

        A moving arm stops first. The path of about the last 1.3 rad is remembered.

        Args:
            distance: Travel of the tool [m]; a shorter path is followed to its end.
            speed: As for `move_to_configuration`.

        Raises:
            MotionError: When there is no such path, or something blocks it.
        """
        distance = check_positive(distance, "distance", "m")
        travelled = self.follower.travelled[::-1]
        self._move(BackOffRequest(travelled, distance, check_speed(speed)))

    @property
    def problem(self) -> str:
        """Why a real arm does not move, such as a reflex; empty in simulation and when ready."""
        return "" if self.connection is None else self.connection.problem

    @property
    def recoverable(self) -> bool:
        """Whether `recover` may clear the `problem` of a real arm."""
        return self.connection is not None and bool(self.problem) and self.connection.recoverable

    def recover(self) -> None:
        """Clear errors and reflexes of a real arm; `problem` tells the result a little later.

        Raises:
            MotionError: When the arm cannot recover by itself.
        """
        if self.connection is None or not self.problem:
            return
        if not self.recoverable:
            raise MotionError(f"the arm cannot recover: {self.problem}", reason="device")
        self.connection.recover()

    def check_ready(self) -> None:
        """Check that a motion can be planned from where the arm is.

        Raises:
            MotionError: When a measurement is not finite, or the arm has not come to rest after a
                compliant stop.
        """
        problem = self.robot.measurement_problem
        if problem:
            raise MotionError(problem, reason="sensor")
        if self.problem:
            raise MotionError(f"the arm does not move: {self.problem}", reason="device")
        if self._recovering:
            raise MotionError(f"the arm has not come to rest yet: {self.fault}", reason="stopping")

    def _move(
        self,
        request: Request,
        *,
        planner: Planner | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Plan a request and follow the result.

        Raises:
            MotionError: When there is no such motion; then nothing changes.
        """
        planner = self.planner if planner is None else planner
        rng = np.random.default_rng(0) if rng is None else check_generator(rng)
        if not callable(getattr(planner, "plan", None)):
            raise MotionError(
                f"a planner is an object with a method plan, got {planner!r}", reason="target"
            )
        self.check_ready()
        delay = partial(self.coordinator.delay, self) if self.coordinator else in_sequence
        scene = PlanningScene(self.model, self.ik, self.world, planner, delay)
        was_guarded = self.moving and self._guarded and not self.fault

        def change() -> None:
            state = self.follower.state._replace(blend_radius=self.blend_radius)
            if self.compliant:
                state = state._replace(q=self.robot.q)
            motion = plan(request, state, scene, rng)
            if self.compliant:
                self.follower.hold_at(state.q)
            self.follower.follow(motion, self.model)

        self._in_time(change, PLANNING_LATENCY)
        self.compliant = False
        contact = isinstance(request, ToolPathRequest | ServoRequest) and request.contact
        self.fault, self._guarded = "", self.world is not None and not contact
        self.blend_radius = 0.0
        if self.guard is not None and not was_guarded:
            self.guard.begin(self.model, self.v, self.a)
            self._unchecked = 0
        if self.coordinator is not None and self.speed_scale < 1.0:
            self.coordinator.motion_changed(self)

    def _in_time(self, change: Callable[[], None], latency: int) -> None:
        """Change the motion; with a connection, so early that the change arrives in time.

        Args:
            change: Plans the change and makes it.
            latency: Control steps from now until it takes effect, at first.

        Raises:
            MotionError: When there is no such motion, or the arm cannot follow it; then nothing
                changes.
        """
        if self.connection is None:
            change()
            return
        try:
            for attempt in range(SEND_ATTEMPTS):
                self.follower.latency = self.connection.lag + latency * 2**attempt
                with suppress(LateError):
                    change()
                    return
        except DeviceError as error:
            raise MotionError(str(error), reason="device") from error
        finally:
            self.follower.latency = 0
        raise MotionError(
            f"planning takes longer than {latency * 2 ** (SEND_ATTEMPTS - 1)} ms: this computer is "
            "too busy for the arm", reason="device",
        )  # fmt: skip

    # The motion

    @property
    def payload(self) -> Payload | None:
        """The payload; the effort limits of motions planned from now on account for it."""
        return self.model.payload

    @payload.setter
    def payload(self, payload: Payload | None) -> None:
        self.model = self.model.with_payload(payload)

    @property
    def moving(self) -> bool:
        """Whether the reference has not come to rest."""
        return self.follower.trajectory is not None

    @property
    def paused(self) -> bool:
        """Whether it rests within a motion, which a speed scale above 0 continues."""
        return self.follower.paused is not None

    @property
    def busy(self) -> bool:
        """Whether a motion has not been completed, moving or paused."""
        return self.moving or self.paused

    @property
    def at_rest(self) -> bool:
        """Whether reference and measured joints are at rest."""
        still = np.abs(self.robot.v).max() <= MAX_REST_JOINT_SPEED
        return not self.moving and bool(still)

    @property
    def undisturbed(self) -> bool:
        """Whether it is at rest and no external torque exceeds the threshold of a contact."""
        settled = self.at_rest and not self._recovering
        return settled and not self.problem and not external_load(self.robot, self.model).exceeded

    @property
    def trajectory(self) -> Trajectory | None:
        """The trajectory being followed; None at rest."""
        return self.follower.trajectory

    @property
    def remaining(self) -> float:
        """Time until the reference comes to rest [s]."""
        return self.follower.remaining

    @property
    def target(self) -> np.ndarray:
        """Configuration in which the reference will come to rest [rad]."""  # (nq,)
        return self.follower.state.target.copy()

    def ends_within(self, radius: float) -> bool:
        """Tell whether the rest of the motion keeps the tool within a radius of its target.

        Args:
            radius: Radius [m], at most `MAX_BLEND` of the distance that the motion moves the tool.
        """
        trajectory = self.trajectory
        if trajectory is None or self.speed_scale == 0.0:  # paused, it rests elsewhere
            return trajectory is None and not self.paused
        start = trajectory.sample(np.zeros(1))[0]
        ahead = self.follower.ahead(np.linspace(0.0, self.remaining, AHEAD_SAMPLES))
        T_target = self.model.pose(trajectory.end).copy()
        length, *left = tool_distance(self.model, np.concatenate([start, ahead]), T_target)
        return bool(max(left) <= min(radius, MAX_BLEND * length))

    @property
    def q_ref(self) -> np.ndarray:
        """A copy of the reference position [rad]."""  # (nq,)
        return self.q.copy()

    @property
    def speed_scale(self) -> float:
        """Fraction of their planned speed that motions have, 0 to 1; 0 pauses.

        It can be changed at any time; a motion stays on its path.
        """
        return self.follower.speed_scale / self.speed_factor

    @speed_scale.setter
    def speed_scale(self, speed_scale: float) -> None:
        speed_scale = check_number(speed_scale, "speed scale", at_least=0.0, at_most=1.0)
        speed_scale *= self.speed_factor
        self._in_time(
            lambda: self.follower.set_speed_scale(speed_scale, self.model), PLANNING_LATENCY
        )
        if self.coordinator is not None:
            self.coordinator.motion_changed(self)

    @property
    def tool_speed(self) -> float:
        """Maximum speed of the tool's origin [m/s]; infinity: unlimited.

        It can be changed at any time, up to the limit of the robot. A motion that is too fast is
        slowed down on its path, as by `speed_scale`; stops are on the path, and not faster than it.
        """
        return self.model.limits.tool_speed

    @tool_speed.setter
    def tool_speed(self, speed: float) -> None:
        if not speed > 0.0:
            raise MotionError(f"the tool's speed must be positive, got {speed}", reason="target")
        if self._limit_tool(speed):
            self.speed_scale = self.speed_scale

    def _limit_tool(self, speed: float) -> bool:
        """Limit the tool's speed, up to the robot's limit; return whether the limit changes."""
        limits, speed = self.model.limits, min(speed, self.robot.limits.tool_speed)
        changes = speed != limits.tool_speed
        if changes:
            self.model = self.model.with_limits(replace(limits, tool_speed=speed))
        return changes

    def pause(self) -> None:
        """Stop on the path; `resume` continues."""
        self.speed_scale = 0.0

    def resume(self) -> None:
        """Continue at speed scale 1."""
        self.speed_scale = 1.0

    def stop(self, fault: str = "", *, compliant: bool = False) -> None:
        """Stop on the path as soon as the limits allow, and discard the motion.

        After a compliant stop the controllers yield to contact, soft and without integral action,
        and the reference moves to the measured configuration once the joints are at rest. Requests
        are refused until then. The next motion begins at the measured configuration.

        Args:
            fault: Why the arm stops by itself, where it does; kept as `fault`.
            compliant: Whether it yields to contact after the stop.
        """
        self._in_time(lambda: self.follower.stop(self.model), STOPPING_LATENCY)
        if not fault:
            self.blend_radius = 0.0
        if compliant and self.connection is None:
            self._recovering, self._settling = True, 0
        if self.coordinator is not None:
            self.coordinator.motion_changed(self)
        if fault:
            self.fault = fault

    def advance(self, dt: float) -> None:
        """Advance the reference by a control step [s]."""
        follower = self.follower
        if follower.trajectory is None:
            if self._recovering and self.connection is None:
                self._recover(dt)
            return
        follower.advance(dt)
        if (
            self._recovering
            and self.connection is None
            and np.abs(self.q - self.robot.q).max() > MAX_TRACKING_ERROR
        ):
            self._hold_compliantly()  # it is blocked: to go on would only press
        if follower.lagging and (not self.moving or not follower.step % RETRY_INTERVAL):
            try:
                self.speed_scale = follower.speed_scale / self.speed_factor
            except MotionError as error:
                self._stop_by_itself(f"its speed could not be changed: {error}")
        if self._guarded:
            self._unchecked += 1
            if self._unchecked >= CHECK_INTERVAL and self.moving and not self.fault:
                self._check_external_forces(dt)

    def give_up(self, fault: str) -> None:
        """Discard the motion of a real arm that does not follow it; requests wait for its rest.

        Args:
            fault: The reason.
        """
        self.follower.hold_at(self.robot.q)
        self.follower.paused = None
        self.fault, self.blend_radius, self._recovering = fault, 0.0, True

    def rest_at(self, q: np.ndarray) -> None:
        """Rest where a real arm rests [rad]."""
        self.follower.hold_at(q)
        self._recovering = False

    def _check_external_forces(self, dt: float) -> None:
        self._unchecked = 0
        found = self.guard.check(self.model, self.v, self.a, dt) if self.guard else None
        if found is not None:
            if np.abs(self.q - self.robot.q).max() > MAX_TRACKING_ERROR:
                found = found._replace(following=False)
            self._stop_by_itself(diagnose(self, found), compliant=True)

    def _stop_by_itself(self, fault: str, *, compliant: bool = False) -> None:
        """Stop, or give up a real arm that takes no stop: what it has ends in one."""
        try:
            self.stop(fault, compliant=compliant)
        except MotionError as error:
            if self.connection is None:
                raise
            self.give_up(f"{fault}; it could not be stopped: {error}")

    def describe_error(self) -> str:
        """Return the likely reason why the arm is not at its reference, or is disturbed."""
        present = external_load(self.robot, self.model)
        return diagnose(self, Detection(present) if present.exceeded else None)

    def _hold_compliantly(self) -> None:
        """Yield to contact at the measured configuration."""
        q = self.robot.q
        self.follower.hold_at(np.where(np.isfinite(q), q, self.q))
        self.compliant = True

    def _recover(self, dt: float) -> None:
        """Yield to contact, and rest at the measured configuration once the joints are at rest."""
        self._settling += 1
        settled = self.compliant and (self.at_rest or self._settling * dt >= RECOVERY_TIMEOUT)
        if not self.compliant or settled:
            self._hold_compliantly()
        if settled:
            self._recovering = False
            if self.coordinator is not None:
                self.coordinator.motion_changed(self)

    # State

    def get_state(self) -> dict[str, Any]:
        """Return everything as plain data."""
        limited = self.tool_speed < self.robot.limits.tool_speed
        return {
            **self.follower.get_state(),
            **({"tool_speed": self.tool_speed} if limited else {}),
            "payload": None if self.payload is None else self.payload.get_state(),
            "fault": self.fault,
            "compliant": self.compliant,
            "blend_radius": self.blend_radius,
            "recovering": self._recovering,
            "settling": self._settling,
            "guarded": self._guarded,
            "unchecked": self._unchecked,
            "guard": None if self.guard is None else self.guard.get_state(),
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Restore what `get_state` returned; the arm continues bit for bit."""
        self.follower.set_state(state)
        payload = state["payload"]
        if payload is not None or self.payload is not None:  # a new model takes a while
            self.payload = None if payload is None else Payload.from_state(payload)
        self._limit_tool(state.get("tool_speed", np.inf))
        self.fault, self._guarded = state["fault"], state["guarded"]
        self.compliant, self._recovering = state["compliant"], state["recovering"]
        self._settling, self.blend_radius = state["settling"], state["blend_radius"]
        self._unchecked = state["unchecked"]
        if self.guard is not None and state["guard"] is not None:
            self.guard.set_state(state["guard"])
