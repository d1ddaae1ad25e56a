"""Open and close the gripper."""

from bt_manip.bt import Input, Status, Traits
from bt_manip.robots import GRIP_FORCE

from .arm_behaviour import GripperBehaviour
from .automatic import number_or_auto


class OpenGripper(GripperBehaviour):
    """Open the gripper; the arm then has no payload."""

    traits = Traits(commands={"gripper"}, leaves={"open": True, "holding": False})

    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].", at_least=0.0)

    def start(self) -> None:
        """Start opening."""
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


class CloseGripper(GripperBehaviour):
    """Close the gripper, with or without an object in it."""

    traits = Traits(commands={"gripper"}, leaves={"open": False, "holding": None})

    force = number_or_auto(
        "Grip force at each contact [N]; auto: the preferred force, or 0.8 of the gripper's "
        "maximum if lower.",
        at_least=0.0,
    )
    preferred_force = Input(float, default=GRIP_FORCE, doc="Preferred grip force for auto [N].")
    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].", at_least=0.0)

    memory = (*GripperBehaviour.memory, "_force")

    _force = 0.0  # [N] commanded

    def start(self) -> None:
        """Start closing."""
        self._force = self.choose_force()
        self.gripper.close(self._force)

    def choose_force(self) -> float:
        """Return the grip force [N]."""
        given = self.force
        return self.gripper.default_force(self.preferred_force) if given is None else given

    def update(self) -> Status:
        """Wait until the grip is steady or the gripper has closed; yield to forces of closing."""
        self.yield_to_force()
        self.feedback_message = self.gripper.status
        if self.gripper.steady or self.gripper.closed_on_nothing:
            return self.closed()
        if self.elapsed > self.patience:
            return self.fail(
                f"no steady grip after {self.patience:g} s: {self.gripper.status}, "
                f"commanded {self._force:g} N"
            )
        return Status.RUNNING

    def closed(self) -> Status:
        """Return the final status of the behaviour after the gripper has closed."""
        return Status.SUCCESS
