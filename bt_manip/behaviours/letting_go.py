"""What behaviours that let go at the end of a motion have in common."""

from bt_manip.bt import Input, Status

from .arm_behaviour import MotionBehaviour


class LettingGoBehaviour(MotionBehaviour):
    """Move, and then open the gripper until it touches nothing."""

    needs_gripper = True

    patience = Input(float, default=2.0, doc="Longest simulated time for the gripper to open [s].")

    memory = (*MotionBehaviour.memory, "_opening")
    amounts = {**MotionBehaviour.amounts, "patience": "s"}

    _opening: float | None = None  # [s] when the gripper began to open

    def initialise(self) -> None:
        """Start the motion, with the gripper as it is."""
        self._opening = None
        super().initialise()

    def let_go(self) -> Status:
        """Open, and wait until the gripper touches nothing."""
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
