"""What behaviours that use the arm have in common."""

from collections.abc import Callable, Mapping
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip.bt import Input, Status
from bt_manip.bt.nodes import Action
from bt_manip.cell import Cell, CellError
from bt_manip.checks import check_non_negative
from bt_manip.control import ControlError
from bt_manip.exceptions import MotionError
from bt_manip.models import ModelError
from bt_manip.registry import UnknownPartError
from bt_manip.robots import GripperError

from .robot_port import RobotPort

FAILURES = (CellError, ControlError, GripperError, ModelError, MotionError, UnknownPartError)
"""Errors for which a behaviour fails; all others end the run."""


class CellBehaviour(Action):
    """A behaviour that looks at the cell, and knows for how long it has been at it."""

    memory: ClassVar[tuple[str, ...]] = ("_started",)

    amounts: ClassVar[Mapping[str, str]] = {}
    """Ports that hold numbers of 0 or above, with their units."""

    _started = 0.0  # [s] simulated

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def initialise(self) -> None:
        """Begin, or fail with the reason why it cannot be done."""
        self._started = self.cell.time
        if self.try_to(self.check_amounts):
            self.try_to(self.start)

    def check_amounts(self) -> None:
        """Refuse amounts that are none.

        Raises:
            MotionError: Naming the port.
        """
        for port, unit in self.amounts.items():
            check_non_negative(getattr(self, port), f"port '{port}'", unit)

    def try_to(self, begin: Callable[[], None]) -> bool:
        """Begin something, or fail with the reason why it cannot be done; tell which it was."""
        try:
            begin()
        except FAILURES as error:
            self.fail(str(error))
            return False
        return True

    def start(self) -> None:
        """Start what the behaviour waits for.

        Raises:
            CellError: When what it refers to is not in the cell.
            MotionError: When there is no such motion.
            GripperError: When the gripper cannot do what is asked, or there is none.
            ModelError: When an address leads to no model.
            UnknownPartError: When nothing is registered by a name.
        """

    @property
    def elapsed(self) -> float:
        """Simulated time since the behaviour began [s]."""
        return self.cell.time - self._started


class ArmBehaviour(RobotPort, CellBehaviour):
    """A behaviour that uses a robot's arm and its gripper."""

    memory: ClassVar[tuple[str, ...]] = (*CellBehaviour.memory, *RobotPort.memory)

    def initialise(self) -> None:
        """Begin with the robot that is meant now."""
        self._started = self.cell.time
        if self.try_to(self.choose_robot) and self.try_to(self.check_amounts):
            self.try_to(self.start)

    def stop_gripper(self) -> None:
        """Stop the gripper, where there is one."""
        gripper = self._robots[self._robot_name].gripper
        if gripper is not None:
            gripper.stop()

    @property
    def T_wt(self) -> pin.SE3:
        """Where the tool is, by the measured joint positions."""
        return self.arm.model.pose(self.arm.robot.q)


class MotionBehaviour(ArmBehaviour):
    """Start a motion, wait until the arm has arrived, brake when halted.

    A motion has arrived when its reference has ended and the measured joints are within
    `ARRIVED` of it; the controller gets `SETTLING` of simulated time for the rest.

    Where another robot is in the way, it is tried again every `RETRY`, for as long as `wait` says.
    """

    ARRIVED = 5e-3  # [rad]; a controller without an integral leaves some friction uncompensated
    SETTLING = 0.5  # [s]
    RETRY = 0.1  # [s]

    wait = Input(
        float,
        default=10.0,
        doc="Longest simulated time to wait for another robot to go out of the way [s].",
    )

    memory: ClassVar[tuple[str, ...]] = (*ArmBehaviour.memory, "_ended", "_blocked", "_tried")
    amounts: ClassVar[Mapping[str, str]] = {"wait": "s"}

    _ended: float | None = None  # [s] when the reference came to rest
    _blocked: float | None = None  # [s] since when another robot has been in the way
    _tried = 0.0  # [s] when the motion was asked for last

    @property
    def largest_error(self) -> float:
        """Error of a joint up to which the arm has arrived [rad]."""
        return self.ARRIVED

    def initialise(self) -> None:
        """Start the motion."""
        self._started, self._ended, self._blocked = self.cell.time, None, None
        if self.try_to(self.choose_robot) and self.try_to(self.check_amounts):
            self.begin_motion(self.start)

    def begin_motion(self, begin: Callable[[], None]) -> Status:
        """Begin a motion, wait where another robot is in its way, or fail and say why.

        Args:
            begin: Asks the arm for the motion.
        """
        try:
            begin()
        except MotionError as error:
            if error.reason != "robot":
                return self.fail(str(error))
            now = self._tried = self.cell.time
            self._blocked = now if self._blocked is None else self._blocked
            if now - self._blocked >= self.wait - 1e-9:
                return self.fail(f"{error}, for {self.wait:g} s" if self.wait else str(error))
            self.feedback_message = f"waits: {error}"
            return Status.RUNNING
        except FAILURES as error:
            return self.fail(str(error))
        self._blocked = None
        return Status.FAILURE if self._node_ended else Status.RUNNING  # it may call `fail` itself

    def begin_again(self) -> Status:
        """Ask once more for the motion that another robot was in the way of."""
        return self.begin_motion(self.start)

    def update(self) -> Status:
        """Wait until the arm has arrived."""
        if self._blocked is not None:
            late = self.cell.time >= self._tried + self.RETRY - 1e-9
            return self.begin_again() if late else Status.RUNNING
        arm = self.arm
        if arm.fault:
            return self.fail(arm.fault)
        if arm.paused:
            self.feedback_message = "paused"
            return Status.RUNNING
        if arm.moving:
            self.feedback_message = f"{arm.remaining:.2f} s to go"
            return Status.RUNNING
        error = float(np.max(np.abs(arm.q - arm.robot.q)))
        if error <= self.largest_error:
            return self.arrived()
        if self._ended is None:
            self._ended = self.cell.time
        if self.cell.time - self._ended > self.SETTLING:
            return self.fail(
                f"the arm came to rest {error:.4f} rad from its target; something holds it"
            )
        self.feedback_message = f"settling, {error:.4f} rad to go"
        return Status.RUNNING

    def arrived(self) -> Status:
        """Say what follows when the arm has arrived; by default the behaviour succeeds."""
        self.feedback_message = "arrived"
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        """Brake when halted in the middle."""
        if new_status == Status.INVALID and self.arm.busy:
            self.arm.stop()
