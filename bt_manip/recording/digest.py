"""A fingerprint of a whole run."""

import hashlib


class StateDigest:
    """SHA-256 over the state of the physics and all node statuses after every tick.

    The state is MuJoCo's integration state: all that the next step depends on. So two runs with
    the same digest went through the same states, bit for bit.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self._hash = hashlib.sha256()

    def update(self, state: bytes, statuses: bytes) -> None:
        """Take in one tick.

        Args:
            state: The integration state, as `bt_manip.cell.Cell.state_bytes` gives it.
            statuses: One byte for each node of the tree.
        """
        self._hash.update(state)
        self._hash.update(statuses)

    def hexdigest(self) -> str:
        """Give the digest of all ticks so far."""
        return self._hash.hexdigest()
