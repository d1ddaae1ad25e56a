"""Remove an object from the cell."""

import numpy as np

from bt_manip.bt import Input, Status

from .arm_behaviour import CellBehaviour


class RemoveObject(CellBehaviour):
    """Wait until an object is at rest, then remove it from the cell."""

    STILL = 5e-3  # [m/s]
    RESTING = 0.05  # [s] below that speed before it counts as at rest

    object = Input(str, doc="Name of the object.")
    patience = Input(
        float, default=2.0, doc="Longest simulated time to wait until it is at rest [s]."
    )

    memory = (*CellBehaviour.memory, "_still_since")

    _still_since: float | None = None

    def start(self) -> None:
        """Check that the object exists."""
        self._still_since = None
        self.cell.find(self.object)

    def update(self) -> Status:
        """Remove the object once it has been at rest for `RESTING`."""
        name = self.object
        speed = float(np.linalg.norm(self.cell.velocity(name)[:3]))
        if speed >= self.STILL:
            self._still_since = None
        elif self._still_since is None:
            self._still_since = self.cell.time
        if self._still_since is not None and self.cell.time - self._still_since >= self.RESTING:
            self.cell.remove(name)
            self.feedback_message = f"'{name}' removed"
            return Status.SUCCESS
        if self.elapsed > self.patience:
            return self.fail(
                f"'{name}' still moves at {1000 * speed:.0f} mm/s after {self.patience:g} s"
            )
        self.feedback_message = f"'{name}' moves at {1000 * speed:.0f} mm/s"
        return Status.RUNNING
