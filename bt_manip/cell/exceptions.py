"""What can go wrong in a cell."""

from bt_manip.exceptions import BtManipError


class CellError(BtManipError):
    """An object that cannot be added, found or removed; the cell is as it was before."""


class OverlapError(CellError):
    """An object would stand inside another one; the cell is as it was before."""


class PhysicsDiverged(RuntimeError):
    """The simulation left the finite numbers: a fault inside, not of what a user wrote."""
