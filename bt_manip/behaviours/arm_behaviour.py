"""What behaviours that use the arm have in common."""

from collections.abc import Callable
from typing import Any, ClassVar

import numpy as np
import pinocchio as pin

from bt_manip.bt import Action, Status
from bt_manip.cell import Cell, CellError
from bt_manip.control import ControlError, GripperController
from bt_manip.models import ModelError
from bt_manip.motion import Arm, MotionError
from bt_manip.registry import UnknownPartError


class CellBehaviour(Action):
    """A behaviour that looks at the cell, and knows for how long it has been at it."""

    memory: ClassVar[tuple[str, ...]] = ("_started",)

    _started = 0.0  # [s] simulated

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def initialise(self) -> None:
        """Begin, or fail with the reason why it cannot be done."""
        self._started = self.cell.time
        self.try_to(self.start)

    def try_to(self, begin: Callable[[], None]) -> bool:
        """Begin something, or fail with the reason why it cannot be done; tell which it was."""
        try:
            begin()
        except (CellError, ControlError, ModelError, MotionError, UnknownPartError) as error:
            self.fail(str(error))
            return False
        return True

    def start(self) -> None:
        """Start what the behaviour waits for.

        Raises:
            CellError: When what it refers to is not in the cell.
            MotionError: When there is no such motion.
            ControlError: When the gripper cannot do what is asked.
            ModelError: When an address leads to no model.
            UnknownPartError: When nothing is registered by a name.
        """

    @property
    def elapsed(self) -> float:
        """Simulated time since the behaviour began [s]."""
        return self.cell.time - self._started


class ArmBehaviour(CellBehaviour):
    """A behaviour that uses the arm and its gripper."""

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell, the arm and its gripper."""
        super().setup(**infrastructure)
        self.arm: Arm = infrastructure["arm"]
        self.gripper: GripperController = infrastructure["gripper"]

    @property
    def T_wt(self) -> pin.SE3:
        """Where the tool is, by the measured joint positions."""
        return self.arm.model.pose(self.arm.robot.q)


class MotionBehaviour(ArmBehaviour):
    """Start a motion, wait until the arm has arrived, brake when halted.

    A motion has arrived when its reference has ended and the measured joints are within
    `ARRIVED` of it; the controller gets `SETTLING` of simulated time for the rest.
    """

    ARRIVED = 5e-3  # [rad]; a controller without an integral leaves some friction uncompensated
    SETTLING = 0.5  # [s]

    memory: ClassVar[tuple[str, ...]] = (*ArmBehaviour.memory, "_ended")

    _ended: float | None = None  # [s] when the reference came to rest

    @property
    def largest_error(self) -> float:
        """Error of a joint up to which the arm has arrived [rad]."""
        return self.ARRIVED

    def initialise(self) -> None:
        """Start the motion."""
        self._ended = None
        super().initialise()

    def update(self) -> Status:
        """Wait until the arm has arrived."""
        if self.arm.fault:
            return self.fail(self.arm.fault)
        if self.arm.paused:
            self.feedback_message = "paused"
            return Status.RUNNING
        if self.arm.moving:
            self.feedback_message = f"{self.arm.remaining:.2f} s to go"
            return Status.RUNNING
        error = float(np.max(np.abs(self.arm.q - self.arm.robot.q)))
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
