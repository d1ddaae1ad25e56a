"""Check that an object is there."""

from typing import Any

from bt_manip.bt import Input, Status
from bt_manip.bt.nodes import Condition
from bt_manip.cell import Cell


class ObjectExists(Condition):
    """Check that the cell has an object."""

    object = Input(str, doc="Name of the object.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def update(self) -> Status:
        """Look the name up."""
        if self.object in self.cell.objects:
            return Status.SUCCESS
        return self.fail(f"the cell has no object '{self.object}'")
