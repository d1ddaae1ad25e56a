"""The arm as behaviours and scripts command it."""

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.robots import Payload, Robot, RobotModel

from .checks import check_configuration, check_inside, check_pace, check_pose, check_speed
from .collision import CollisionWorld
from .deviation_guard import EVERY, DeviationGuard
from .errors import MotionError
from .goal_choice import choose_configurations
from .kinematics import InverseKinematics
from .move_planning import Avoiding, plan_to_configurations, plan_tool_path
from .planning import Planner, RRTConnect
from .reference import Reference
from .tool_path import LineTo, Step
from .traffic import Traffic
from .trajectory import Trajectory

MARGIN = 0.05  # [rad] that chosen configurations keep from the limits where they can


class Arm:
    """Plan motions and give the reference that a controller follows.

    A motion is planned when it is asked for, as a whole and inside all limits, or a `MotionError`
    says why it cannot be done and nothing changes. Afterwards `advance` moves the reference along
    it. Asked for in the middle of another motion, a new one starts from the present reference
    position, velocity and acceleration.

    Attributes:
        robot: The robot, for its measured joint positions.
        model: Its model, with the payload.
        ik: Its inverse kinematics.
        world: What its motions shall not touch; None where it does not look.
        planner: Finds ways around what is in the way.
        guard: Notices that something pushes the arm, which stops it; None where nobody looks.
        traffic: Keeps it out of the way of other arms; None where there are none.
        fault: Why the arm stopped by itself, empty when it did not; the next motion clears it.
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
        guard: DeviationGuard | None = None,
    ) -> None:
        """Begin where the robot is.

        Args:
            robot: A compiled robot.
            model: Its model; by default made from the robot.
            ik: Its inverse kinematics; by default made from the model.
            world: What its motions shall not touch; by default it does not look.
            planner: Finds ways around what is in the way; by default `RRTConnect`.
            guard: Notices that something pushes the arm; by default nobody looks.
        """
        self.robot = robot
        self.model = robot.make_model() if model is None else model
        self.ik = InverseKinematics(self.model) if ik is None else ik
        self.world = world
        self.planner = RRTConnect() if planner is None else planner
        self.guard = guard
        self.traffic: Traffic | None = None
        self.fault, self._guarded = "", False
        self._reference = Reference(robot.q)
        self.q, self.v, self.a = self._reference.q, self._reference.v, self._reference.a

    def reset(self, q: np.ndarray | None = None) -> None:
        """Forget all motion and stand at a configuration, by default where the robot is."""
        self._reference.reset(self.robot.q if q is None else q)

    # What is moved

    @property
    def payload(self) -> Payload | None:
        """What the arm carries; efforts of motions planned from now on count it in."""
        return self.model.payload

    @payload.setter
    def payload(self, payload: Payload | None) -> None:
        self.model = self.model.with_payload(payload)

    @property
    def moving(self) -> bool:
        """Whether the reference has not yet come to rest."""
        return self._reference.trajectory is not None

    @property
    def paused(self) -> bool:
        """Whether it rests in the middle of a motion, which a pace above 0 goes on with."""
        return self._reference.paused is not None

    @property
    def busy(self) -> bool:
        """Whether a motion has not come to its end, moving or paused."""
        return self.moving or self.paused

    @property
    def trajectory(self) -> Trajectory | None:
        """What is being driven; None at rest."""
        return self._reference.trajectory

    @property
    def elapsed(self) -> float:
        """Time since the start of the trajectory [s]."""
        return self._reference.time

    @property
    def remaining(self) -> float:
        """Time until the reference comes to rest [s]."""
        return self._reference.remaining

    @property
    def stopping(self) -> bool:
        """Whether it has been told to stop and has not come to rest yet."""
        return self._reference.stopping

    def ahead(self, times: np.ndarray) -> np.ndarray:
        """Give where the reference will be, some times from now on, if nobody interferes.

        Args:
            times: From now on [s].  # (n,)

        Returns:
            Positions of the joints [rad].  # (n, nq)
        """
        return self._reference.ahead(times)

    @property
    def target(self) -> np.ndarray:
        """Configuration that the reference will come to rest at [rad]."""  # (nq,)
        trajectory = self._reference.trajectory
        return (self.q if trajectory is None else trajectory.end).copy()

    @property
    def q_ref(self) -> np.ndarray:
        """A copy of the reference position [rad]."""  # (nq,)
        return self.q.copy()

    @property
    def v_ref(self) -> np.ndarray:
        """A copy of the reference velocity [rad/s]."""  # (nq,)
        return self.v.copy()

    @property
    def a_ref(self) -> np.ndarray:
        """A copy of the reference acceleration [rad/s2]."""  # (nq,)
        return self.a.copy()

    # How it is moved

    def move_to_configuration(
        self,
        q: Sequence[float] | np.ndarray,
        speed: float = 1.0,
        *,
        planner: Planner | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Move the joints to a configuration, on the straight line where it is free.

        Args:
            q: Where to [rad].  # (nq,)
            speed: 1 is as fast as the limits allow; a move from rest at 0.5 takes twice the time.
            planner: Finds a way around what is in the way; by default the arm's own.
            rng: What it draws from; by default a new generator, so that the same request gives the
                same answer.

        Raises:
            MotionError: When the target is none, is outside the limits or inside an obstacle, when
                no way is found, or the motion asks too much effort.
        """
        speed = check_speed(speed)
        target = check_configuration(q, self.model.nq)
        check_inside(target, self.model.limits)
        avoiding = self._avoiding(planner, rng)
        self._begin(
            plan_to_configurations(self._reference.present, [target], self.model, speed, avoiding)
        )

    def move_to_pose(
        self,
        T_wt: pin.SE3 | Sequence[pin.SE3],
        speed: float = 1.0,
        *,
        margin: float = MARGIN,
        approach: float = 0.0,
        planner: Planner | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        """Move the joints to the nearest configuration that puts the tool at a pose.

        Args:
            T_wt: Pose of the tool in the world, or several that serve equally well.
            speed: As for `move_to_configuration`.
            margin: How far from the joint limits to stay where that is possible [rad].
            approach: How far the tool shall be able to go on from there, straight along its z
                axis [m], where a configuration allows that.
            planner: As for `move_to_configuration`.
            rng: As for `move_to_configuration`.

        Raises:
            MotionError: When no pose can be reached or all are inside obstacles, when no way is
                found, or the motion asks too much effort.
        """
        speed = check_speed(speed)
        found = choose_configurations(
            self.ik, T_wt, self.q, margin=margin, approach=approach, world=self.world
        )
        best = next(found)
        if not best.solved:
            message = f"the pose is unreachable: {best.reason}"
            if best.iterations:
                message += (
                    f"; nearest found is {1e3 * best.position_error:.1f} mm and "
                    f"{best.rotation_error:.3f} rad away"
                )
            raise MotionError(message, reason="unreachable")
        targets = itertools.chain([best.q], (result.q for result in found))
        avoiding = self._avoiding(planner, rng)
        self._begin(
            plan_to_configurations(self._reference.present, targets, self.model, speed, avoiding)
        )

    def move_linear(self, T_wt: pin.SE3, speed: float = 1.0, *, contact: bool = False) -> None:
        """Move the tool to a pose on a straight line, turning evenly on the way.

        A moving arm comes to rest first.

        Args:
            T_wt: Pose of the tool in the world.
            speed: 1 is as fast as joints and tool may; at 0.5 it takes twice the time.
            contact: Whether it shall touch something: then nobody minds what is in its way, nor
                what pushes the arm.

        Raises:
            MotionError: When the line cannot be followed to its end (the message says how far),
                would touch something, or asks too much effort.
        """
        self.move_path([LineTo(T_wt)], speed, contact=contact)

    def move_path(
        self,
        steps: Sequence[Step],
        speed: float = 1.0,
        *,
        blend: float = 0.0,
        contact: bool = False,
    ) -> None:
        """Move the tool along lines and arcs, without a halt where its corners are rounded.

        A moving arm comes to rest first.

        Args:
            steps: `LineTo`, `ArcTo` and `TurnAbout`, in their order.
            speed: As for `move_linear`.
            blend: How far from a corner it is rounded [m]; at 0 the tool halts there.
            contact: As for `move_linear`.

        Raises:
            MotionError: When the path cannot be followed to its end (the message and `fraction`
                say how far), would touch something, or asks too much effort.
        """
        speed = check_speed(speed)
        world = None if contact else self.world
        present = self._reference.present
        path = plan_tool_path(present, steps, blend, self.model, self.ik, speed, world)
        self._begin(path, guarded=world is not None)

    def follow(self, T_wt: pin.SE3, speed: float = 1.0) -> None:
        """Turn towards a target that moves; to be called again as it does.

        The arm goes on from what it is doing, and comes to rest at the target if this is not
        called again. It stays near the configurations that it came by.

        Args:
            T_wt: Pose of the tool in the world, now.
            speed: 1 is as fast as the limits allow.

        Raises:
            MotionError: When the pose cannot be reached, or is inside an obstacle.
        """
        speed = check_speed(speed)
        found = self.ik.follow(check_pose(T_wt), self.target)
        if not found.solved:
            found = self.ik.nearest(T_wt, self.target)
        if not found.solved:
            raise MotionError(f"the pose is unreachable: {found.reason}", reason="unreachable")
        avoiding = self._avoiding(None, None)
        self._begin(
            plan_to_configurations(self._reference.present, [found.q], self.model, speed, avoiding)
        )

    def stop(self) -> None:
        """Come to rest as soon as the limits allow, on the planned path where there is one."""
        self._reference.stop(self.model)
        if self.traffic is not None:
            self.traffic.changed(self)

    def give_up(self, fault: str) -> None:
        """Stop, and keep in mind why."""
        self.stop()
        self.fault = fault

    @property
    def pace(self) -> float:
        """Fraction of their planned speed that motions are driven at, 0 to 1; 0 pauses.

        It can be changed at any time, also in the middle of a motion, which stays on its path.
        """
        return self._reference.pace

    @pace.setter
    def pace(self, pace: float) -> None:
        self._reference.change_pace(check_pace(pace), self.model)
        if self.traffic is not None:
            self.traffic.changed(self)

    def pause(self) -> None:
        """Come to rest on the path; `resume` goes on."""
        self.pace = 0.0

    def resume(self) -> None:
        """Go on at full pace."""
        self.pace = 1.0

    def advance(self, dt: float) -> None:
        """Move the reference on by a control step [s]."""
        reference = self._reference
        if reference.trajectory is None:
            return
        reference.advance(dt)
        if self._guarded and not reference.step % EVERY and self.moving and not self.fault:
            self._look(dt)

    def _look(self, dt: float) -> None:
        """Stop when something pushes the arm, and remember why."""
        fault = "" if self.guard is None else self.guard.look(self.model, self.v, self.a, dt)
        if fault:
            touching = "" if self.world is None else self.world.touching_now()
            self.give_up(f"{fault}; {touching}" if touching else fault)

    # Planning

    def _avoiding(
        self, planner: Planner | None, rng: np.random.Generator | None
    ) -> Avoiding | None:
        if self.world is None:
            return None
        return Avoiding(
            self.world,
            self.planner if planner is None else planner,
            np.random.default_rng(0) if rng is None else rng,
        )

    def _begin(self, trajectory: Trajectory | None, guarded: bool = True) -> None:
        """Take a planned motion, at the present pace, as soon as other arms let it pass."""
        if self.traffic is not None and trajectory is not None:
            trajectory = self.traffic.give_way(self, trajectory)
        self.fault, self._guarded = "", guarded and self.world is not None
        if self.guard is not None:
            self.guard.begin(self.model, self.v, self.a)
        self._reference.begin(trajectory, self.model)
        if self.traffic is not None and self.pace < 1.0:
            self.traffic.changed(self)

    # State

    def get_state(self) -> dict[str, Any]:
        """Give everything as plain data."""
        return {
            **self._reference.get_state(),
            "payload": None if self.payload is None else self.payload.get_state(),
            "fault": self.fault,
            "guarded": self._guarded,
            "guard": None if self.guard is None else self.guard.get_state(),
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Take everything back; the arm goes on bit for bit."""
        self._reference.set_state(state)
        self.payload = None if state["payload"] is None else Payload.from_state(state["payload"])
        self.fault, self._guarded = state["fault"], state["guarded"]
        if self.guard is not None and state["guard"] is not None:
            self.guard.set_state(state["guard"])
