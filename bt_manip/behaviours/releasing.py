"""Base class of behaviours that release an object after a motion."""

from bt_manip.bt import Input, Status

from .arm_behaviour import MotionBehaviour


class ReleasingBehaviour(MotionBehaviour):
    """Move, then open the gripper until it is free."""

    needs_gripper = True

    patience = Input(float, default=2.0, doc="Timeout for opening, in simulated time [s].")

    memory = (*MotionBehaviour.memory, "_opening")
    amounts = {**MotionBehaviour.amounts, "patience": "s"}

    _opening: float | None = None  # [s] start of the opening

    def initialise(self) -> None:
        """Start the motion without moving the gripper."""
        self._opening = None
        super().initialise()

    def release(self) -> Status:
        """Open the gripper and wait until it is free."""
        if self._opening is None:
            self._opening = self.cell.time
            self.gripper.open()
        self.feedback_message = f"opening: {self.gripper.status}"
        if self.gripper.is_free and self.gripper.is_open:
            self.arm.payload = None
            return Status.SUCCESS
        if self.cell.time - self._opening > self.patience:
            touching = ", ".join(self.gripper.held) or "something"
            return self.fail(f"the gripper still touches {touching} after {self.patience:g} s")
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop arm and gripper when halted."""
        super().terminate(new_status)
        if new_status == Status.INVALID:
            self.stop_gripper()
