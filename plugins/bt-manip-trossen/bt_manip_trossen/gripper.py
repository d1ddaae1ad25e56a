"""The gripper: two carriages that one motor moves, on the connection of the arm."""

import time
from typing import TYPE_CHECKING, NamedTuple

from bt_manip.robots import DeviceError, GripperDevice, GripperState

if TYPE_CHECKING:
    from .arm import WidowXAI

PERIOD = 0.02  # [s] between two commands
SETTLED = 1e-4  # [m] of a carriage in a period
TIMEOUT = 3.0  # [s] until the carriages rest
THINNEST = 4e-3  # [m] of an object
PRESSING = 2.0  # [N] of the motor, from which something is gripped
REACHED = 3e-3  # [m] from a commanded width


class Carriage(NamedTuple):
    """Position of a carriage [m], and effort of the motor [N]."""

    position: float
    effort: float


class Carriages(GripperDevice):
    """The parallel gripper, whose width is twice the position of a carriage.

    The position mode controls no force: the target goes beyond the object until the motor has the
    effort that is asked for, one half for each finger.
    """

    def __init__(self, arm: "WidowXAI") -> None:
        """Keep the arm, which is connected first."""
        self._arm, self._grasped, self._width = arm, False, 0.0

    def connect(self) -> None:
        """Do nothing: it is connected with the arm."""

    def close(self) -> None:
        """Do nothing: it is disconnected with the arm."""

    def read(self) -> GripperState:
        """Return the width, and whether an object is still pressed."""
        output = self._arm.call(lambda driver: driver.get_robot_output())
        if output is None:
            return GripperState(self._width, self._grasped, "the arm has a problem")
        now = output.joint.gripper
        self._width = 2.0 * now.position
        pressed = self._width > THINNEST and abs(now.effort) > PRESSING
        return GripperState(self._width, self._grasped and pressed)

    def grasp(self, width: float, speed: float, force: float) -> bool:
        """Close until the motor presses with twice the force; return whether something is there."""
        self._travel(0.0, speed, effort=2.0 * force)
        now = self._settle()
        self._grasped = 2.0 * now.position > THINNEST and abs(now.effort) > PRESSING
        return self._grasped

    def move(self, width: float, speed: float) -> bool:
        """Move to a width."""
        self._grasped = False
        self._travel(0.5 * width, speed)
        return abs(2.0 * self._settle().position - width) < REACHED

    def _travel(self, goal: float, speed: float, effort: float = float("inf")) -> None:
        """Move the target of a carriage, up to an effort of the motor."""
        step, target = 0.5 * speed * PERIOD, self._now().position
        while abs(goal - target) > 1e-9 and abs(self._now().effort) < effort:
            target += min(max(goal - target, -step), step)
            self._command(target)
            time.sleep(PERIOD)

    def _settle(self) -> Carriage:
        """Wait until the carriages rest."""
        end, before = time.monotonic() + TIMEOUT, self._now()
        while time.monotonic() < end:
            time.sleep(5.0 * PERIOD)
            now = self._now()
            if abs(now.position - before.position) < SETTLED:
                return now
            before = now
        return before

    def _now(self) -> Carriage:
        output = self._arm.call(lambda driver: driver.get_robot_output())
        if output is None:
            raise DeviceError("the arm has a problem, and its gripper with it")
        return Carriage(output.joint.gripper.position, output.joint.gripper.effort)

    def _command(self, position: float) -> None:
        self._arm.call(lambda driver: driver.set_gripper_position(position, 0.0, False))
