"""An arm on its way: what it follows, at which pace, and what makes it stop."""

from collections.abc import Callable
from typing import Any

import numpy as np

from bt_manip.checks import check_number
from bt_manip.collision import CollisionWorld
from bt_manip.robots import Payload, Robot, RobotModel
from bt_manip.trajectories import Trajectory

from .coordination import MultiArmCoordinator
from .external_force_guard import EVERY, ExternalForceGuard
from .motion_planning import Present
from .reference import Reference

RETRY = 20  # control steps after which a change of the pace is tried again


class MovingArm:
    """Give the reference that a controller follows, along trajectories that others plan.

    `advance` moves the reference along what it has been given, step by step. It can be driven
    more slowly, paused and stopped at any time, and stops by itself where something pushes it.

    Attributes:
        robot: The robot, for its measured joint positions.
        model: Its model, with the payload.
        world: What its motions shall not touch; None where it does not look.
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
        model: RobotModel,
        world: CollisionWorld | None,
        guard: ExternalForceGuard | None,
    ) -> None:
        """Begin where the robot is.

        Args:
            robot: A compiled robot.
            model: Its model.
            world: What its motions shall not touch.
            guard: Notices that something pushes the arm.
        """
        self.robot, self.model, self.world, self.guard = robot, model, world, guard
        self.traffic: MultiArmCoordinator | None = None
        self.fault, self._guarded = "", False
        self._unseen = 0  # control steps since the guard looked
        self._reference = Reference(robot.q)
        self.q, self.v, self.a = self._reference.q, self._reference.v, self._reference.a

    def reset(self, q: np.ndarray | None = None) -> None:
        """Forget all motion and stand at a configuration, by default where the robot is."""
        self._reference.reset(self.robot.q if q is None else q)

    def hold_at(self, q: np.ndarray) -> None:
        """Continue from the measured configuration [rad] if at rest; ignored while busy.

        Called when another controller takes over: it starts without a position error.
        """
        if not self.busy:
            self._reference.hold_at(q)

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

    # How it goes on

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
    def speed_scale(self) -> float:
        """Fraction of their planned speed that motions are driven at, 0 to 1; 0 pauses.

        It can be changed at any time, also in the middle of a motion, which stays on its path.
        """
        return self._reference.pace

    @speed_scale.setter
    def speed_scale(self, speed_scale: float) -> None:
        speed_scale = check_number(speed_scale, "speed scale", at_least=0.0, at_most=1.0)
        self._reference.set_speed_scale(speed_scale, self.model)
        if self.traffic is not None:
            self.traffic.changed(self)

    def pause(self) -> None:
        """Come to rest on the path; `resume` goes on."""
        self.speed_scale = 0.0

    def resume(self) -> None:
        """Go on at full pace."""
        self.speed_scale = 1.0

    def advance(self, dt: float) -> None:
        """Move the reference on by a control step [s]."""
        reference = self._reference
        if reference.trajectory is None:
            return
        reference.advance(dt)
        if reference.lagging and not reference.step % RETRY:
            self.speed_scale = reference.pace
        if self._guarded:
            self._unseen += 1
            if self._unseen >= EVERY and self.moving and not self.fault:
                self._look(dt)

    def _look(self, dt: float) -> None:
        """Stop when something pushes the arm, and remember why."""
        self._unseen = 0
        fault = "" if self.guard is None else self.guard.look(self.model, self.v, self.a, dt)
        if fault:
            touching = "" if self.world is None else self.world.touching_now()
            self.give_up(f"{fault}; {touching}" if touching else fault)

    def _begin(self, plan: Callable[[Present], Trajectory | None], *, guarded: bool = True) -> None:
        """Plan a motion and take it, at the present pace, as soon as other arms let it pass.

        Args:
            plan: Plans it from what the arm does.
            guarded: Whether it shall stop where something pushes the arm.

        Raises:
            MotionError: When there is no such motion; then nothing changes.
        """
        watched = self.moving and self._guarded and not self.fault
        for present in self._reference.presents():
            trajectory = plan(present)
            if self.traffic is not None and trajectory is not None:
                trajectory = self.traffic.yield_to_others(self, trajectory)
            if self._reference.begin(trajectory, present, self.model):
                break
        self.fault, self._guarded = "", guarded and self.world is not None
        if self.guard is not None and not watched:  # else it goes on as what it was watched in
            self.guard.begin(self.model, self.v, self.a)
            self._unseen = 0
        if self.traffic is not None and self.speed_scale < 1.0:
            self.traffic.changed(self)

    # State

    def get_state(self) -> dict[str, Any]:
        """Give everything as plain data."""
        return {
            **self._reference.get_state(),
            "payload": None if self.payload is None else self.payload.get_state(),
            "fault": self.fault,
            "guarded": self._guarded,
            "unseen": self._unseen,
            "guard": None if self.guard is None else self.guard.get_state(),
        }

    def set_state(self, state: dict[str, Any]) -> None:
        """Take everything back; the arm goes on bit for bit."""
        self._reference.set_state(state)
        payload = state["payload"]
        if payload is not None or self.payload is not None:  # a new model takes a while
            self.payload = None if payload is None else Payload.from_state(payload)
        self.fault, self._guarded = state["fault"], state["guarded"]
        self._unseen = state["unseen"]
        if self.guard is not None and state["guard"] is not None:
            self.guard.set_state(state["guard"])
