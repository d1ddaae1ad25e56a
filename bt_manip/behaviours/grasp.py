"""Grasp an object."""

from bt_manip.bt import Input, Status
from bt_manip.grasping import check_friction

from .arm_behaviour import ArmBehaviour
from .payload import payload_of


class Grasp(ArmBehaviour):
    """Close the gripper on an object until the grip is steady.

    The grip is steady when its force has stayed near the commanded one for a while; the impact of
    closing exceeds any force for milliseconds. The object then becomes the arm's payload.
    """

    needs_gripper = True

    object = Input(str, doc="Name of the object.")
    force = Input(float, default=50.0, doc="Gripping force at each contact [N].")
    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Start to close."""
        self.cell.find(self.object)
        check_friction(self.cell, self.gripper, self.object, self.force)
        self.gripper.close(self.force)

    def update(self) -> Status:
        """Wait for a steady grip."""
        self.feedback_message = self.gripper.status
        if self.gripper.steady:
            return self._held()
        if self.gripper.closed_on_nothing:
            return self.fail(f"the gripper closed without gripping '{self.object}'")
        if self.elapsed > self.patience:
            return self.fail(
                f"no steady grip after {self.patience:g} s: {self.gripper.status}, "
                f"commanded {self.force:g} N"
            )
        return Status.RUNNING

    def _held(self) -> Status:
        held = self.gripper.held
        if self.object not in held:
            return self.fail(
                f"the gripper holds {', '.join(held) or 'nothing'}, not '{self.object}'"
            )
        self.arm.payload = payload_of(self.cell, self.object, self.T_wt)
        return Status.SUCCESS

    def terminate(self, new_status: Status) -> None:
        """Stop closing when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()
