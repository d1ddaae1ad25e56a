"""Check where an object rests."""

from typing import Any

from bt_manip.bt import Input, Status
from bt_manip.bt.nodes import Condition
from bt_manip.cell import Cell, CellError, why_not_in, why_not_on


class RestingCondition(Condition):
    """A condition on where an object rests."""

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
        """Check the physics."""
        try:
            reason = self.why_not()
        except CellError as error:
            reason = str(error)
        return self.fail(reason) if reason else Status.SUCCESS


class IsIn(RestingCondition):
    """Check that an object rests inside a container.

    It is at rest, touches only the container and objects that move freely, has its centre within
    the container's outline, and is supported from below inside the container, also by another
    object in it. An object that is still gripped is not in the container.
    """

    container = Input(str, doc="Name of the container.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and supported inside the container."""
        return why_not_in(self.cell, self.object, self.container)


class IsOn(RestingCondition):
    """Check that an object rests on another one.

    It is at rest, no robot touches it, and the other one carries at least a quarter of its weight.
    """

    support = Input(str, doc="Name of the object below it.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and carried by the support."""
        return why_not_on(self.cell, self.object, self.support)
