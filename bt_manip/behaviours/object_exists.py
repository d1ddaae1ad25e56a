"""Check that the cell has an object."""

from typing import Any

from bt_manip.bt import Input, Status
from bt_manip.bt.nodes import Condition
from bt_manip.cell import Cell


class ObjectExists(Condition):
    """Check that the cell has an object of a name."""

    object = Input(str, doc="Name of the object.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def update(self) -> Status:
        """Look up the name."""
        if self.object in self.cell.objects:
            return Status.SUCCESS
        return self.fail(f"the cell has no object '{self.object}'")
