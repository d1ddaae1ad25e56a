"""Digest of all states of a run."""

import hashlib


class StateDigest:
    """SHA-256, chained over the state of the physics and all node statuses after every tick.

    The state is MuJoCo's integration state, on which the next step depends. Two runs with the same
    digest have the same states, bit for bit. The digest of a tick covers the previous digest, the
    state and the statuses, so a run can be continued from a saved digest.
    """

    def __init__(self) -> None:
        """Initialise with an empty digest."""
        self._digest = b""

    def update(self, state: bytes, statuses: bytes) -> None:
        """Add one tick.

        Args:
            state: The integration state, as returned by `bt_manip.cell.Cell.state_bytes`.
            statuses: One byte for each node of the tree.
        """
        taken = hashlib.sha256(self._digest)
        taken.update(state)
        taken.update(statuses)
        self._digest = taken.digest()

    def hexdigest(self) -> str:
        """Return the digest of all ticks so far, as hexadecimal digits."""
        return self._digest.hex() or hashlib.sha256().hexdigest()

    def get_state(self) -> str:
        """Return the digest of all ticks so far; empty without ticks."""
        return self._digest.hex()

    def set_state(self, state: str) -> None:
        """Continue from a digest."""
        self._digest = bytes.fromhex(state)
