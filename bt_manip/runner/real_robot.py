"""A real robot, as the loop of a run sees it: robot time, changes sent ahead, problems."""

from contextlib import suppress
from dataclasses import dataclass
from typing import Any

import numpy as np

from bt_manip.arm import SENT_AHEAD, Arm
from bt_manip.cell.randomization import Randomization
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.registry import Parts
from bt_manip.robots import (
    ArmConnection,
    Backend,
    DeviceError,
    Gripper,
    GripperConnection,
    LateError,
    MotionLimits,
)
from bt_manip.scenes import Scene
from bt_manip.trajectories import CONTROL_STEP

REFRESH = 100
"""Control steps between two messages with the next part of a motion."""

LATENCY = 25
"""Control steps from such a message until it takes effect."""

LATE = 5
"""Control steps by which a tick may be late without being counted."""

MOST = 100
"""Control steps that are simulated in a tick; of a longer pause only the time passes."""

SILENT = "the arm has stopped on its path: no motion arrived in time"

ASTRAY = 1e-3
"""Difference of the references here and of the arm from which it goes another way [rad]."""

MOVED = 0.02
"""Distance by which a joint at rest has been moved by someone else [rad]."""


@dataclass(frozen=True)
class BackendChoice:
    """A registered backend and the address of the robot.

    Attributes:
        backend: The backend.
        name: Its name.
        address: The address.
    """

    backend: Backend
    name: str
    address: str

    def check_controller(self, name: str) -> None:
        """Check that the vendor has a controller.

        Raises:
            BtManipError: If it has none of this name.
        """
        known = self.backend.controllers
        if name not in known:
            raise BtManipError(
                f"backend '{self.name}' has no controller '{name}'{did_you_mean(name, known)}"
            )

    def connect_arm(self, limits: MotionLimits) -> ArmConnection:
        """Connect the arm.

        Raises:
            DeviceError: If it cannot be reached.
        """
        return ArmConnection(self.backend.arm, self.address, limits)

    def connect_gripper(self) -> GripperConnection:
        """Connect and home the gripper.

        Raises:
            DeviceError: If it cannot be reached, or there is none.
        """
        if self.backend.gripper is None:
            raise DeviceError(f"backend '{self.name}' has no gripper", self.address)
        return GripperConnection(self.backend.gripper, self.address)


def find_backend(text: str, parts: Parts) -> BackendChoice:
    """Return the backend of a text ``NAME=ADDRESS``.

    Raises:
        BtManipError: If there is none, or no address.
    """
    name, _, address = text.partition("=")
    if name not in parts.backends:
        note = did_you_mean(name, parts.backends) or "; no plugin brings one"
        raise BtManipError(f"unknown backend '{name}'{note}{parts.backends.note}")
    backend = parts.backends.get(name)
    if not address:
        raise BtManipError(f"--backend wants {name}=ADDRESS, where ADDRESS is {backend.address}")
    return BackendChoice(backend, name, address)


def check_real(scene: Scene, choice: BackendChoice) -> None:
    """Check that a scene can be one of a real robot.

    Raises:
        BtManipError: If it has several robots, or varies from cycle to cycle.
    """
    if len(scene.robots) > 1:
        raise BtManipError(f"backend '{choice.name}' moves one robot, the scene has several")
    if scene.randomization != Randomization():
        raise BtManipError(f"backend '{choice.name}': a real cell cannot be randomized")


class RealRobot:
    """Keeps a simulated cell in step with a real robot.

    Attributes:
        choice: The backend.
        late_ticks: Ticks that took longer than their period.
    """

    def __init__(
        self, choice: BackendChoice, connection: ArmConnection, arm: Arm, gripper: Gripper | None
    ) -> None:
        """Put the simulated arm where the real one is.

        Args:
            choice: The backend.
            connection: The connection to the arm.
            arm: The arm of the simulated cell.
            gripper: Its gripper.
        """
        self.choice, self._connection, self._arm, self._gripper = choice, connection, arm, gripper
        self.late_ticks = self._sent_at = self._known_until = 0
        self._moved = False  # whether it was to move in the present tick
        self._more = False  # whether the motion goes on beyond what was sent
        connection.setpoint += connection.lag
        arm.robot.set_configuration(connection.latest.q)
        arm.connection = connection
        arm.follower.send = self._send
        arm.reset(connection.latest.q_ref)

    def wait(self, steps: int) -> int:
        """Wait for the end of a tick; return the control steps that have passed.

        Args:
            steps: Control steps in a tick.

        Raises:
            DeviceError: If the robot does not go on.
        """
        passed = self._connection.wait(steps)
        self._moved = self._arm.moving
        self.late_ticks += passed > steps + LATE
        for _ in range(passed - MOST):  # to catch up
            self._connection.setpoint += 1
            self._arm.advance(CONTROL_STEP)
            self._arm.robot.mj_data.time += CONTROL_STEP
        return min(passed, MOST)

    def update(self) -> None:
        """Follow the robot after the control steps of a tick.

        Raises:
            DeviceError: If the gripper does not answer.
        """
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
    def report(self) -> dict[str, Any]:
        """What a report says about the robot, as plain data."""
        gripper = getattr(self._gripper, "assumed", ())
        return {
            "backend": self.choice.name,
            "late_ticks": self.late_ticks,
            "lost_cycles": self._connection.lost_cycles,
            "longest_gap_s": self._connection.longest_gap,
            "assumed": sorted(gripper),
            **self._connection.properties,
        }

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
