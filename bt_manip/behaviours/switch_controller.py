"""Switch the controller of an arm."""

import contextlib
from typing import Any

from bt_manip.bt import Input, Status, Traits
from bt_manip.exceptions import PortError

from .arm_behaviour import ArmBehaviour


class SwitchController(ArmBehaviour):
    """Activate another controller of the arm, without a step in torque.

    An arm at rest holds its measured configuration; a motion continues. After a cycle, the arm
    returns to its own controller once it is at rest.
    """

    traits = Traits()
    controller = Input(
        str, default="", doc="Registered name of the controller; by default the arm's own."
    )

    def setup(self, **infrastructure: Any) -> None:
        """Create the controller, if port and robot are already known.

        Raises:
            ControlError: If there is no such controller.
        """
        super().setup(**infrastructure)
        with contextlib.suppress(PortError):
            if self.robot_name and self.controller:
                self.controllers.get(self.controller)

    def start(self) -> None:
        """Switch."""
        self.controllers.switch(self.controller or self.controllers.default)

    def update(self) -> Status:
        """Succeed; the torques are faded while the tree continues."""
        self.feedback_message = self.controllers.active
        return Status.SUCCESS
