"""The base class of conditions on an object in the cell."""

from typing import Any, ClassVar

from bt_manip.bt import Input, Status
from bt_manip.bt.nodes import Condition
from bt_manip.cell import Cell, CellError


class ObjectCondition(Condition):
    """A condition on an object in the cell.

    Attributes:
        destination: Port that names where the object shall be, for goal-conditioned environments;
            empty if the condition is not about its position.
    """

    destination: ClassVar[str] = ""

    object = Input(str, doc="Name of the object.")

    def setup(self, **infrastructure: Any) -> None:
        """Keep the cell."""
        self.cell: Cell = infrastructure["cell"]

    def why_not(self) -> str:
        """Return why the condition does not hold; empty if it does.

        Raises:
            CellError: If the cell lacks an object.
        """
        raise NotImplementedError

    def update(self) -> Status:
        """Check the cell."""
        try:
            reason = self.why_not()
        except CellError as error:
            reason = str(error)
        return self.fail(reason) if reason else Status.SUCCESS
