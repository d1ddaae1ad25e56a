"""Open and close the gripper."""

from bt_manip.bt import Input, Status

from .arm_behaviour import ArmBehaviour
from .automatic import number_or_auto
from .grasp import default_force, preferred_force_input


class OpenGripper(ArmBehaviour):
    """Open the gripper; the arm then has no payload."""

    needs_gripper = True

    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}

    def start(self) -> None:
        """Start to open."""
        self.gripper.open()

    def update(self) -> Status:
        """Wait until the gripper is open."""
        self.feedback_message = self.gripper.status
        if self.gripper.is_open:
            self.arm.payload = None
            return Status.SUCCESS
        if self.elapsed > self.patience:
            return self.fail(
                f"the gripper is not open after {self.patience:g} s ({self.gripper.status}); "
                "something obstructs it"
            )
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop opening when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()


class CloseGripper(ArmBehaviour):
    """Close the gripper, with or without an object in it."""

    needs_gripper = True

    force = number_or_auto(
        "Gripping force at each contact [N]; auto: the preferred one, or 0.8 of the gripper's "
        "maximum if that is lower."
    )
    preferred_force = preferred_force_input()
    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].")

    amounts = {"patience": "s"}
    memory = (*ArmBehaviour.memory, "_force")

    _force = 0.0  # [N] commanded

    def start(self) -> None:
        """Start to close."""
        given = self.force
        self._force = default_force(self.gripper, self.preferred_force) if given is None else given
        self.gripper.close(self._force)

    def update(self) -> Status:
        """Wait until the gripper holds steadily or has closed; yield to the forces of closing."""
        self.yield_to_force()
        self.feedback_message = self.gripper.status
        if self.gripper.steady or self.gripper.closed_on_nothing:
            return Status.SUCCESS
        if self.elapsed > self.patience:
            return self.fail(
                f"no steady grip after {self.patience:g} s: {self.gripper.status}, "
                f"commanded {self._force:g} N"
            )
        return Status.RUNNING

    def terminate(self, new_status: Status) -> None:
        """Stop closing when halted."""
        if new_status == Status.INVALID:
            self.stop_gripper()
