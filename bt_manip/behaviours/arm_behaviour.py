"""What behaviours that use the arm have in common."""

from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip.bt import Action, Status
from bt_manip.cell import Cell, CellError
from bt_manip.control import ControlError, GripperController
from bt_manip.motion import Arm, MotionError
from bt_manip.registry import UnknownPartError


class CellBehaviour(Action):
    """A behaviour that looks at the cell, and knows for how long it has been at it."""

    _started = 0.0  # [s] simulated

    def setup(self, *, cell: Cell, **_: Any) -> None:
        """Keep the cell."""
        self.cell = cell

    def initialise(self) -> None:
        """Begin, or fail with the reason why it cannot be done."""
        self._started = self.cell.time
        try:
            self.start()
        except (CellError, ControlError, MotionError, UnknownPartError) as error:
            self.fail(str(error))

    def start(self) -> None:
        """Start what the behaviour waits for.

        Raises:
            CellError: When what it refers to is not in the cell.
            MotionError: When there is no such motion.
            ControlError: When the gripper cannot do what is asked.
            UnknownPartError: When nothing is registered by a name.
        """

    @property
    def elapsed(self) -> float:
        """Simulated time since the behaviour began [s]."""
        return self.cell.time - self._started

    def get_state(self) -> dict[str, Any]:
        """Give when the behaviour began."""
        return {**super().get_state(), "started": self._started}

    def set_state(self, state: dict[str, Any]) -> None:
        """Take back when the behaviour began."""
        super().set_state(state)
        self._started = state["started"]


class ArmBehaviour(CellBehaviour):
    """A behaviour that uses the arm and its gripper."""

    def setup(self, *, cell: Cell, arm: Arm, gripper: GripperController, **_: Any) -> None:
        """Keep the cell, the arm and its gripper."""
        super().setup(cell=cell)
        self.arm = arm
        self.gripper = gripper

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

    _ended: float | None = None  # [s] when the reference came to rest

    def initialise(self) -> None:
        """Start the motion."""
        self._ended = None
        super().initialise()

    def update(self) -> Status:
        """Wait until the arm has arrived."""
        if self.arm.moving:
            self.feedback_message = f"{self.arm.remaining:.2f} s to go"
            return Status.RUNNING
        error = float(np.max(np.abs(self.arm.q - self.arm.robot.q)))
        if error <= self.ARRIVED:
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
        if new_status == Status.INVALID and self.arm.moving:
            self.arm.stop()

    def get_state(self) -> dict[str, Any]:
        """Give what a running motion remembers."""
        return {**super().get_state(), "ended": self._ended}

    def set_state(self, state: dict[str, Any]) -> None:
        """Take back what a running motion remembers."""
        super().set_state(state)
        self._ended = state["ended"]
