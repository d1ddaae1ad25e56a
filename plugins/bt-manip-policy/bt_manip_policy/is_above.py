"""Check that an object is above another one."""

from bt_manip.behaviours import ObjectCondition, extent
from bt_manip.bt import Input


class IsAbove(ObjectCondition):
    """Check that an object is higher than another one, beside or over it."""

    support = Input(str, doc="Name of the object below it.")
    height = Input(
        float, default=0.05, doc="Minimum height of its bottom over the other's top [m]."
    )

    def why_not(self) -> str:
        """Compare the heights of bottom and top."""
        bottom, top = extent(self.cell, self.object)[0][2], extent(self.cell, self.support)[1][2]
        if bottom - top >= self.height:
            return ""
        return f"'{self.object}' is {1e3 * (bottom - top):.1f} mm above '{self.support}'"
