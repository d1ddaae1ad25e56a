"""Errors of models."""

from bt_manip.exceptions import BtManipError


class ModelError(BtManipError):
    """A model cannot be found, fetched or read."""
