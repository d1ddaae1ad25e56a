"""Contacts that begin and end, from step to step."""

from typing import NamedTuple

from bt_manip.cell.contacts.contacts import Contacts


class ContactEvent(NamedTuple):
    """Two bodies begin to press each other, or cease to."""

    time: float
    """When the step was made in which that was so [s]."""
    first: str
    second: str
    begins: bool


class ContactEventDetector:
    """Compares the pairs that touch with those of the step before."""

    def __init__(self, contacts: Contacts):
        """Begin with the pairs that touch now."""
        self._contacts = contacts
        self._pairs = set(contacts.pairs())
        self._key = contacts.fingerprint()

    def look(self, contacts: Contacts, time: float) -> list[ContactEvent]:
        """Give what has changed since the last look, by name; ends first.

        Args:
            contacts: The contacts of now, of this or of another compile.
            time: The time of now [s].
        """
        key = contacts.fingerprint()
        if key == self._key and contacts is self._contacts:  # ids mean others after a compile
            return []
        before, self._pairs = self._pairs, set(contacts.pairs())
        self._contacts, self._key = contacts, key
        ended = [ContactEvent(time, *pair, False) for pair in sorted(before - self._pairs)]
        return ended + [ContactEvent(time, *pair, True) for pair in sorted(self._pairs - before)]
