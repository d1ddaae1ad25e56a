"""Events of contacts that begin and end."""

from typing import NamedTuple

from .contacts import Contacts


class ContactEvent(NamedTuple):
    """Two bodies come into contact, or lose contact."""

    time: float
    """Simulated time of the step [s]."""
    first: str
    second: str
    begins: bool


class ContactEventDetector:
    """Compares the pairs in contact with those of the step before."""

    def __init__(self, contacts: Contacts):
        """Begin with the pairs that are in contact now."""
        self._contacts = contacts
        self._pairs = set(contacts.pairs())
        self._key = contacts.fingerprint()

    def update(self, contacts: Contacts, time: float) -> list[ContactEvent]:
        """Return the events since the last update, sorted by name; ends first.

        Args:
            contacts: The present contacts, of the same or of a later compile.
            time: The present time [s].
        """
        key = contacts.fingerprint()
        if key == self._key and contacts is self._contacts:  # a compile changes ids
            return []
        before, self._pairs = self._pairs, set(contacts.pairs())
        self._contacts, self._key = contacts, key
        ended = [ContactEvent(time, *pair, False) for pair in sorted(before - self._pairs)]
        return ended + [ContactEvent(time, *pair, True) for pair in sorted(self._pairs - before)]
