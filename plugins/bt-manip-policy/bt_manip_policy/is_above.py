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
        if (above := self._above()) >= self.height:
            return ""
        return f"'{self.object}' is {1e3 * above:.1f} mm above '{self.support}'"

    def progress(self) -> float:
        """Return 1 at the height, less below."""
        return 1.0 / (1.0 + max(self.height - self._above(), 0.0) / self.height)

    def _above(self) -> float:
        """Return the height of the object's bottom over the other's top [m]."""
        bottom, top = extent(self.cell, self.object)[0][2], extent(self.cell, self.support)[1][2]
        return float(bottom - top)
