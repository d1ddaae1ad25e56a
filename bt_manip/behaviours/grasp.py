"""Grasp an object between the fingers."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour
from .payload import payload_of


class Grasp(ArmBehaviour):
    """Close the gripper on an object until both fingers press it steadily.

    The grasp has succeeded when the gripper calls its grip steady: the normal force on each
    finger has stayed near the asked one for a while. The closing impact passes any force within
    milliseconds, so a single sample says nothing. From then on the object is the arm's payload.
    """

    object = Input(str, doc="Name of the object.")
    force = Input(float, default=50.0, doc="Normal force of each finger [N].")
    patience = Input(float, default=2.0, doc="Longest simulated time to try [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Start to close."""
        self.cell.find(self.object)
        self.gripper.close(self.force)

    def update(self) -> Status:
        """Wait for a steady force on both fingers."""
        left, right = self.gripper.finger_forces
        self.feedback_message = f"fingers press with {left:.0f} and {right:.0f} N"
        if self.gripper.steady:
            return self._held()
        if self.gripper.closed_on_nothing:
            return self.fail(f"the fingers met without '{self.object}' between them")
        if self.elapsed > self.patience:
            return self.fail(
                f"no steady grip after {self.patience:g} s: the fingers press with {left:.1f} "
                f"and {right:.1f} N, asked {self.force:g} N"
            )
        return Status.RUNNING

    def _held(self) -> Status:
        held = self.gripper.held
        if self.object not in held:
            return self.fail(
                f"the fingers hold {', '.join(held) or 'nothing'}, not '{self.object}'"
            )
        self.arm.payload = payload_of(self.cell, self.object, self.T_wt)
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        """Stop closing when halted."""
        if new_status == Status.INVALID:
            self.gripper.stop()
