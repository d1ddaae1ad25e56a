"""Errors of a cell."""

from bt_manip.exceptions import BtManipError


class CellError(BtManipError):
    """An object cannot be added, found or removed; the cell is unchanged."""


class OverlapError(CellError):
    """An object would penetrate another one; the cell is unchanged."""


class PhysicsDiverged(RuntimeError):
    """The simulation became unstable: an internal fault, not a user's error."""
