"""What can go wrong between an address and a model."""

from bt_manip.exceptions import BtManipError


class ModelError(BtManipError):
    """A model that cannot be found, fetched or read; nothing of it is left on the disk."""
