"""Base classes of behaviours that use the cell or an arm."""

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
    """A behaviour that uses the cell and measures its own simulated time."""

    memory: ClassVar[tuple[str, ...]] = ("_started",)

    amounts: ClassVar[Mapping[str, str]] = {}
    """Ports that must not be negative, with their units."""

    _started = 0.0  # [s] simulated

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def initialise(self) -> None:
        """Start, or fail with the reason."""
        self._started = self.cell.time
        if self.try_to(self.check_amounts):
            self.try_to(self.start)

    def check_amounts(self) -> None:
        """Check that the ports in `amounts` are not negative.

        Raises:
            MotionError: Naming the port.
        """
        for port, unit in self.amounts.items():
            check_non_negative(getattr(self, port), f"port '{port}'", unit)

    def try_to(self, begin: Callable[[], None]) -> bool:
        """Call a function, or fail with its error; return whether it succeeded."""
        try:
            begin()
        except FAILURES as error:
            self.fail(str(error))
            return False
        return True

    def start(self) -> None:
        """Start what the behaviour waits for.

        Raises:
            CellError: When an object is not in the cell.
            MotionError: When the motion is not feasible.
            GripperError: When there is no gripper or it rejects the command.
            ModelError: When a model cannot be found.
            UnknownPartError: When a name is not registered.
        """

    @property
    def elapsed(self) -> float:
        """Simulated time since the behaviour began [s]."""
        return self.cell.time - self._started


class ArmBehaviour(RobotPort, CellBehaviour):
    """A behaviour that uses a robot's arm and its gripper."""

    memory: ClassVar[tuple[str, ...]] = (*CellBehaviour.memory, *RobotPort.memory)

    def initialise(self) -> None:
        """Start with the selected robot."""
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
        """Pose of the tool at the measured joint positions."""
        return self.arm.model.pose(self.arm.robot.q)


class MotionBehaviour(ArmBehaviour):
    """Start a motion, wait until the arm has arrived, and stop it when halted.

    A motion has arrived when its reference has ended and the measured joints are within
    `ARRIVED` of it; the controller gets `SETTLING` of simulated time for the rest.

    A motion that another robot blocks is retried every `RETRY`, for up to `wait` seconds.
    """

    ARRIVED = 5e-3  # [rad]; a controller without an integral leaves some friction uncompensated
    SETTLING = 0.5  # [s]
    RETRY = 0.1  # [s]

    wait = Input(
        float,
        default=10.0,
        doc="Longest simulated time to wait for another robot that blocks the motion [s].",
    )

    memory: ClassVar[tuple[str, ...]] = (*ArmBehaviour.memory, "_ended", "_blocked", "_tried")
    amounts: ClassVar[Mapping[str, str]] = {"wait": "s"}

    _ended: float | None = None  # [s] when the reference came to rest
    _blocked: float | None = None  # [s] since when another robot has blocked the motion
    _tried = 0.0  # [s] of the last attempt

    @property
    def largest_error(self) -> float:
        """Largest joint error at which the arm has arrived [rad]."""
        return self.ARRIVED

    def initialise(self) -> None:
        """Start the motion."""
        self._started, self._ended, self._blocked = self.cell.time, None, None
        if self.try_to(self.choose_robot) and self.try_to(self.check_amounts):
            self.begin_motion(self.start)

    def begin_motion(self, begin: Callable[[], None]) -> Status:
        """Start a motion, wait while another robot blocks it, or fail with the reason.

        After a fault it also waits until the arm has come to rest.

        Args:
            begin: Requests the motion from the arm.
        """
        try:
            self.arm.check_ready()
            begin()
        except MotionError as error:
            if error.reason not in ("robot", "stopping"):
                return self.fail(str(error))
            now = self._tried = self.cell.time
            self._blocked = now if self._blocked is None else self._blocked
            if error.reason == "robot" and now - self._blocked >= self.wait - 1e-9:
                return self.fail(f"{error}, for {self.wait:g} s" if self.wait else str(error))
            self.feedback_message = f"waiting: {error}"
            return Status.RUNNING
        except FAILURES as error:
            return self.fail(str(error))
        self._blocked = None
        return Status.FAILURE if self._node_ended else Status.RUNNING  # it may call `fail` itself

    def begin_again(self) -> Status:
        """Retry the motion that another robot blocked."""
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
            self.feedback_message = f"{arm.remaining:.2f} s left"
            return Status.RUNNING
        error = float(np.max(np.abs(arm.q - arm.robot.q)))
        if error <= self.largest_error:
            return self.arrived()
        if self._ended is None:
            self._ended = self.cell.time
        if self.cell.time - self._ended > self.SETTLING:
            return self.fail(
                f"the arm stopped {error:.4f} rad from its target; something obstructs it"
            )
        self.feedback_message = f"settling, {error:.4f} rad left"
        return Status.RUNNING

    def arrived(self) -> Status:
        """Return the status after arrival; by default SUCCESS."""
        self.feedback_message = "arrived"
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        """Stop the arm when halted during the motion."""
        if new_status == Status.INVALID and self.arm.busy:
            self.arm.stop()
