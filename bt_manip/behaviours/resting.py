"""Check where an object rests."""

from bt_manip.bt import Input
from bt_manip.cell import why_not_in, why_not_on

from .object_condition import ObjectCondition


class IsIn(ObjectCondition):
    """Check that an object rests inside a container.

    It is at rest, touches only the container and objects that move freely, has its centre within
    the container's outline, and is supported from below inside the container, also by another
    object in it. An object that is still gripped is not in the container.
    """

    destination = "container"

    container = Input(str, doc="Name of the container.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and supported inside the container."""
        return why_not_in(self.cell, self.object, self.container)


class IsOn(ObjectCondition):
    """Check that an object rests on another one.

    It is at rest, no robot touches it, and the other one carries at least a quarter of its weight.
    """

    destination = "support"

    support = Input(str, doc="Name of the object below it.")

    def why_not(self) -> str:
        """Check that the object is released, at rest, and carried by the support."""
        return why_not_on(self.cell, self.object, self.support)
