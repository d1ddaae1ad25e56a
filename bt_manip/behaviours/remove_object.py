"""Remove an object from the cell."""

from typing import Any

from bt_manip.bt import Input, Status

from .arm_behaviour import CellBehaviour
from .awaited_objects import AwaitedObjects


class RemoveObject(CellBehaviour):
    """Wait until an object is at rest, then remove it from the cell.

    An object that does not come to rest is removed too, and the behaviour fails.
    """

    object = Input(str, doc="Name of the object.")
    patience = Input(
        float, default=2.0, doc="Longest simulated time to wait until it is at rest [s]."
    )

    amounts = {"patience": "s"}

    def setup(self, **infrastructure: Any) -> None:
        """Keep the expected objects of the scene."""
        super().setup(**infrastructure)
        self._poses: AwaitedObjects | None = infrastructure.get("poses")

    def start(self) -> None:
        """Check that the object exists."""
        self.cell.find(self.object)

    def update(self) -> Status:
        """Remove the object once it is at rest, or after the timeout."""
        name = self.object
        status = self.wait_for_rest(name, self.patience, self._started)
        if status is not Status.RUNNING and name in self.cell.entities:
            self.cell.remove(name)
            if self._poses is not None:
                self._poses.taken(name)
            if status is Status.SUCCESS:
                self.feedback_message = f"'{name}' removed"
        return status
