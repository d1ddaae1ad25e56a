"""Wait until an object is at rest."""

from bt_manip.bt import Input, Status, Traits

from .arm_behaviour import CellBehaviour
from .object_port import ObjectInput


class WaitUntilAtRest(CellBehaviour):
    """Wait until an object is at rest; succeed immediately if it is."""

    traits = Traits()
    object = ObjectInput(str, doc="Name of the object.")
    patience = Input(float, default=2.0, doc="Timeout in simulated time [s].", at_least=0.0)

    def start(self) -> None:
        """Check that the object exists."""
        self.cell.find(self.object)

    def update(self) -> Status:
        """Check the object's velocity."""
        return self.wait_for_rest(self.object, self.patience, self._started)
