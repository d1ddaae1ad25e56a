"""A real robot, as the loop of a run sees it: robot time, changes sent ahead, problems."""

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import Any, cast

import numpy as np

from bt_manip.arm import SENT_AHEAD
from bt_manip.cell import Cell
from bt_manip.cell.randomization import Randomization
from bt_manip.control import MeasuredArm
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts
from bt_manip.robots import (
    ArmConnection,
    Backend,
    DeviceError,
    Gripper,
    GripperConnection,
    LateError,
    Robot,
)
from bt_manip.scenes import Scene, SceneRobot
from bt_manip.trajectories import CONTROL_STEP

from .commanded_robot import CommandedRobot, RobotBuilder, Simulation, make_robot
from .hardware import Hardware

REFRESH = 100
"""Control steps between two messages with the next part of a motion."""

LATENCY = 25
"""Control steps from such a message until it takes effect."""

LATE = 5
"""Control steps by which a tick may be late without being counted."""

MOST = 100
"""Control steps that are simulated in a tick; of a longer pause only the time passes."""

TOOL_SPEED = 0.25
"""Limit of the tool's speed where no other is given: the reduced speed of ISO 10218-1 [m/s]."""

SILENT = "the arm has stopped on its path: no motion arrived in time"

ASTRAY = 1e-3
"""Difference of the references here and of the arm from which it goes another way [rad]."""

MOVED = 0.02
"""Distance by which a joint at rest has been moved by someone else [rad]."""


@dataclass(frozen=True)
class RealBackend(Simulation):
    """Connects to a real robot at an address, by a registered backend."""

    backend: Backend
    name: str
    address: str

    @property
    def default_controller(self) -> str:  # type: ignore[override]
        """The vendor's first controller."""
        return self.backend.controllers[0]

    def check(self, scene: Scene) -> None:
        """Raise a `BtManipError` for a scene of several robots, or that varies."""
        if len(scene.robots) > 1:
            raise BtManipError(f"backend '{self.name}' moves one robot, the scene has several")
        if scene.randomization != Randomization():
            raise BtManipError(f"backend '{self.name}': a real cell cannot be randomized")

    def builder(self, chosen: SceneRobot, parts: Parts) -> RobotBuilder:
        """Return the builder of the robot; raise if the vendor has no such controller."""
        name, known = str(chosen.controller), self.backend.controllers
        if name not in known:
            raise BtManipError(
                f"backend '{self.name}' has no controller '{name}'{did_you_mean(name, known)}"
            )
        return RealRobotBuilder(chosen, parts, self)

    def hardware(self, cell: Cell, robots: Mapping[str, CommandedRobot]) -> "RealRobot":
        """Return the real robot, which the cell follows."""
        (robot,) = robots.values()
        return RealRobot(cell, self, robot)


class RealRobotBuilder(RobotBuilder):
    """Builds the robot of a scene as the twin of a real one, to which it connects."""

    def __init__(self, chosen: SceneRobot, parts: Parts, backend: RealBackend) -> None:
        self._backend = backend
        self._connection: ArmConnection
        super().__init__(chosen, parts)

    def commanded(self, name: str, cell: Cell) -> CommandedRobot:
        """Return the robot with an arm whose motions the real arm executes."""
        robot = super().commanded(name, cell)
        self._connection.set_limits(robot.arm.model.limits)
        robot.arm.connection = self._connection
        return robot

    def _make_robot(self, parts: Parts) -> Robot:
        robot = make_robot(
            self._chosen, parts, lambda kind: partial(self._make_gripper, parts, kind), TOOL_SPEED
        )
        if robot.gripper is None:
            self._connect(robot)
        return robot

    def _connect(self, robot: Robot) -> None:
        backend = self._backend
        self._connection = ArmConnection(backend.backend.arm, backend.address, robot.limits)

    def _make_gripper(self, parts: Parts, kind: str, robot: Robot) -> Gripper:
        """Connect the arm, then its gripper, on the arm's connection or its own."""
        self._connect(robot)
        backend, arm = self._backend, self._connection
        gripper = backend.backend.gripper
        if gripper is None and arm.gripper_pipe is None:
            raise DeviceError(f"backend '{backend.name}' has no gripper", backend.address)
        made: Any = parts.grippers.get(kind)
        connection = GripperConnection(gripper, backend.address, arm)
        return cast(Gripper, made.on_device(connection)(robot))

    def _controller_factories(self, parts: Parts) -> dict[str, Any]:
        make = partial(MeasuredArm, connection=self._connection)
        return dict.fromkeys(self._backend.backend.controllers, make)


def find_backend(text: str, parts: Parts) -> Simulation:
    """Return the backend of a text ``NAME=ADDRESS``; without a text, the simulation."""
    if not text:
        return Simulation()
    name, _, address = text.partition("=")
    backend = parts.backends.get(name)
    if not address:
        raise BtManipError(f"--backend wants {name}=ADDRESS, where ADDRESS is {backend.address}")
    return RealBackend(backend, name, address)


class RealRobot(Hardware):
    """Executes control steps on a real robot, which the cell follows.

    At first it puts the simulated arm where the real one is. `late_ticks` took longer than their
    period.
    """

    simulated = False

    def __init__(self, cell: Cell, backend: RealBackend, robot: CommandedRobot) -> None:
        super().__init__(cell)
        arm, connection = robot.arm, robot.arm.connection
        assert connection is not None
        self._backend, self._connection = backend, connection
        self._arm, self._gripper = arm, robot.gripper
        self.late_ticks = self._sent_at = self._known_until = 0
        self._moved = False  # whether it was to move in the present tick
        self._more = False  # whether the motion goes on beyond what was sent
        connection.setpoint += connection.lag
        arm.robot.set_configuration(connection.latest.q)
        arm.follower.send = self._send
        arm.reset(connection.latest.q_ref)

    def step(self, steps: int, then: Sequence[Callable[[], None]] = ()) -> None:
        """Wait for the robot to make control steps, and make as many as it has made in the cell.

        Raises a `DeviceError` if the robot does not go on, or its gripper does not answer.
        """
        passed = self._connection.wait(steps)
        self._moved = self._arm.moving
        self.late_ticks += passed > steps + LATE
        for _ in range(passed - MOST):  # to catch up
            self._connection.setpoint += 1
            self._arm.advance(CONTROL_STEP)
            self._arm.robot.mj_data.time += CONTROL_STEP
        super().step(min(passed, MOST), then)
        self._follow()

    def _follow(self) -> None:
        """Follow the robot after the control steps of a tick."""
        arm, connection = self._arm, self._connection
        if self._gripper is not None:
            self._gripper.update()
        astray = bool(np.abs(connection.last.q_ref - arm.q).max() > ASTRAY)
        if self._moved and connection.problem:
            arm.give_up(f"the arm has stopped: {connection.problem}")
        elif self._moved and astray:
            arm.give_up(SILENT)
        elif arm.moving:
            self._send_on()
        if not arm.moving and not connection.streaming:
            self._rest(connection.latest.q_ref)

    def close(self) -> None:
        """End the connection, once the arm is at rest."""
        self._connection.close()
        if self._gripper is not None:
            self._gripper.close_connection()

    @property
    def speeds(self) -> str:  # type: ignore[override]
        """How fast the arm moves at most, for users."""
        speed, limit = self._arm.speed_factor, self._arm.robot.limits.tool_speed
        tool = f"its tool at most at {limit:g} m/s" if limit < np.inf else "its tool without limit"
        text = f"The arm moves at {100.0 * speed:g} % of its speed, {tool}."
        if self._measures_forces:
            return text
        return f"{text} It measures no external forces: contacts do not stop it."

    @property
    def report(self) -> dict[str, Any]:  # type: ignore[override]
        """Backend, speeds, late ticks, lost cycles and properties of the robot, as plain data."""
        gripper, limit = getattr(self._gripper, "assumed", ()), self._arm.robot.limits.tool_speed
        return {
            "backend": self._backend.name,
            "speed": self._arm.speed_factor,
            "tool_speed_m_s": limit if limit < np.inf else None,
            "late_ticks": self.late_ticks,
            "lost_cycles": self._connection.lost_cycles,
            "longest_gap_s": self._connection.longest_gap,
            "external_forces": "measured" if self._measures_forces else "unknown",
            "assumed": sorted(gripper),
            **self._connection.properties,
        }

    @property
    def _measures_forces(self) -> bool:
        return self._arm.guard is not None and self._arm.guard.measures

    def _send(self, latency: int, setpoints: np.ndarray) -> None:
        self._connection.send(latency, setpoints)
        self._more, self._sent_at = True, self._connection.setpoint
        self._known_until = self._connection.setpoint + latency + SENT_AHEAD

    def _send_on(self) -> None:
        """Send the next part of the motion; without it the arm stops on its path."""
        arm, connection = self._arm, self._connection
        if not self._more or connection.setpoint - self._sent_at < REFRESH:
            return
        latency = connection.lag + LATENCY
        if connection.setpoint + latency > self._known_until:  # the arm stops by then
            arm.give_up(SILENT)
            return
        with suppress(LateError):
            try:
                self._more = arm.follower.send_on(latency, arm.model)
            except DeviceError as error:
                arm.give_up(str(error))

    def _rest(self, q: np.ndarray) -> None:
        moved = np.abs(q - self._arm.q)
        joint = int(moved.argmax())
        if moved[joint] > MOVED and not self._arm.fault:
            self._arm.fault = f"the arm was moved: joint {joint + 1} by {moved[joint]:.3f} rad"
        self._arm.rest_at(q)
