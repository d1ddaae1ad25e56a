"""Base class of behaviours that release an object after a motion."""

from collections.abc import Sequence

from bt_manip.bt import Input, Status, Traits

from .arm_behaviour import MotionBehaviour


class ReleasingBehaviour(MotionBehaviour):
    """Move, open the gripper until it is free, and check the object's pose at rest."""

    needs_gripper = True
    traits = Traits(
        commands={"arm", "gripper"},
        needs={"holding"},
        leaves={"open": True, "at_object": None, "holding": False},
    )

    patience = Input(
        float,
        default=2.0,
        doc="Timeout for opening and for the object to come to rest, in simulated time [s].",
        at_least=0.0,
    )

    memory = (*MotionBehaviour.memory, "_opening", "_released")

    _opening: float | None = None  # [s] start of the opening
    _released: Sequence[str] = ()

    def initialise(self) -> None:
        """Start the motion without moving the gripper."""
        self._opening = None
        super().initialise()

    def why_not_released(self, name: str) -> str:
        """Return why an object at rest is not at its target; empty if it is.

        Raises:
            CellError: If the target is no longer in the cell.
        """
        raise NotImplementedError

    def release(self) -> Status:
        """Open the gripper, wait until the object is at rest, and check its pose."""
        if self._opening is None:
            self._opening = self.cell.time
            self._released, self._carried = self._carried, []
            self.gripper.open()
        if self.gripper.is_free and self.gripper.is_open:
            self.arm.payload = None
            for name in self._released:
                status = self.wait_for_rest(name, self.patience, self._opening)
                if status is not Status.SUCCESS:
                    return status
            for name in self._released:
                if reason := self.why_not_released(name):
                    return self.fail(reason)
            return Status.SUCCESS
        self.feedback_message = f"opening: {self.gripper.status}"
        if self.cell.time - self._opening > self.patience:
            touching = ", ".join(self.gripper.held) or "something"
            return self.fail(f"the gripper still touches {touching} after {self.patience:g} s")
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop arm and gripper when halted."""
        super().terminate(new_status)
        if new_status == Status.INVALID:
            self.stop_gripper()
