"""Check that the cell has an object."""

from .object_condition import ObjectCondition


class ObjectExists(ObjectCondition):
    """Check that the cell has an object of a name."""

    def why_not(self) -> str:
        """Look up the name."""
        return "" if self.object in self.cell.objects else f"the cell has no object '{self.object}'"
