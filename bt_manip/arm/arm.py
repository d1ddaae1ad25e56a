"""The arm as behaviours and scripts command it."""

import itertools
from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin

from bt_manip.checks import (
    check_configuration,
    check_generator,
    check_non_negative,
    check_pose,
    check_position_limits,
    check_speed,
)
from bt_manip.collision import CollisionWorld
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import InverseKinematics
from bt_manip.planning import LineTo, Planner, RRTConnect, Step, goal_configurations
from bt_manip.robots import Robot, RobotModel
from bt_manip.trajectories import Trajectory

from .external_force_guard import ExternalForceGuard
from .motion_planning import CollisionAvoidance, Present, plan_to_configurations, plan_tool_path
from .moving_arm import MovingArm

MARGIN = 0.05  # [rad] that chosen configurations keep from the limits where they can


class Arm(MovingArm):
    """Plan motions, and go along them as a `MovingArm`.

    A motion is planned when it is asked for, as a whole and inside all limits, or a `MotionError`
    says why it cannot be done and nothing changes. Afterwards `advance` moves the reference along
    it. Asked for in the middle of another motion, a new one starts from the present reference
    position, velocity and acceleration.

    Attributes:
        ik: Its inverse kinematics.
        planner: Finds ways around what is in the way.
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
        """Begin where the robot is.

        Args:
            robot: A compiled robot.
            model: Its model; by default made from the robot.
            ik: Its inverse kinematics; by default made from the model.
            world: What its motions shall not touch; by default it does not look.
            planner: Finds ways around what is in the way; by default `RRTConnect`.
            guard: Notices that something pushes the arm; by default nobody looks.
        """
        model = robot.make_model() if model is None else model
        super().__init__(robot, model, world, guard)
        self.ik = InverseKinematics(model) if ik is None else ik
        self.planner = RRTConnect() if planner is None else planner

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
        check_position_limits(target, self.model.limits.lower, self.model.limits.upper)
        avoiding = self._avoiding(planner, rng)
        self._begin(
            lambda present: plan_to_configurations(present, [target], self.model, speed, avoiding)
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
        margin = check_non_negative(margin, "margin from the joint limits", "rad")
        approach = check_non_negative(approach, "approach along the tool's axis", "m")
        avoiding = self._avoiding(planner, rng)
        found = goal_configurations(
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
        targets: Iterator[np.ndarray] = itertools.chain([best.q], (end.q for end in found))

        def plan(present: Present) -> Trajectory | None:
            nonlocal targets
            targets, mine = itertools.tee(targets)  # it may be planned more than once
            return plan_to_configurations(present, mine, self.model, speed, avoiding)

        self._begin(plan)

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
        self._begin(
            lambda present: plan_tool_path(
                present, steps, blend, self.model, self.ik, speed, world
            ),
            guarded=world is not None,
        )

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
            lambda present: plan_to_configurations(
                present, [found.q], self.model, speed, avoiding, follows=True
            )
        )

    # Inside

    def _avoiding(
        self, planner: Planner | None, rng: np.random.Generator | None
    ) -> CollisionAvoidance | None:
        planner = self.planner if planner is None else planner
        rng = np.random.default_rng(0) if rng is None else check_generator(rng)
        if not callable(getattr(planner, "plan", None)):
            raise MotionError(
                f"a planner is an object with a method plan, got {planner!r}", reason="target"
            )
        return None if self.world is None else CollisionAvoidance(self.world, planner, rng)
