"""The behaviour."""

import numpy as np
from bt_manip.behaviours import CellBehaviour
from bt_manip.bt import Input, Status


class Gear(CellBehaviour):
    """Wait until an object is at rest."""

    object = Input(str, doc="Name of the object.")
    speed = Input(float, default=1e-3, doc="Largest speed of an object at rest [m/s].")
    patience = Input(float, default=2.0, doc="Longest simulated time to wait [s].")

    def start(self):
        """Start; a CellError raised here becomes the reason of a failure."""
        self.cell.find(self.object)

    def update(self):
        """Check once per tick, without waiting or stepping the cell."""
        speed = float(np.linalg.norm(self.cell.velocity(self.object)[:3]))
        self.feedback_message = f"{1e3 * speed:.1f} mm/s"
        if speed <= self.speed:
            return Status.SUCCESS
        if self.elapsed > self.patience:
            return self.fail(f"'{self.object}' still moves with {speed:.3f} m/s")
        return Status.RUNNING
