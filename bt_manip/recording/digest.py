"""A fingerprint of a whole run."""

import hashlib


class StateDigest:
    """SHA-256, chained over the state of the physics and all node statuses after every tick.

    The state is MuJoCo's integration state: all that the next step depends on. So two runs with
    the same digest went through the same states, bit for bit. Each tick's digest is that of the
    tick before, of the state and of the statuses: what is known of a run can be kept and gone on
    from.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self._digest = b""

    def update(self, state: bytes, statuses: bytes) -> None:
        """Take in one tick.

        Args:
            state: The integration state, as `bt_manip.cell.Cell.state_bytes` gives it.
            statuses: One byte for each node of the tree.
        """
        taken = hashlib.sha256(self._digest)
        taken.update(state)
        taken.update(statuses)
        self._digest = taken.digest()

    def hexdigest(self) -> str:
        """Give the digest of all ticks so far."""
        return self._digest.hex() or hashlib.sha256().hexdigest()

    def get_state(self) -> str:
        """Give the digest of all ticks so far, empty where there were none."""
        return self._digest.hex()

    def set_state(self, state: str) -> None:
        """Go on from a digest."""
        self._digest = bytes.fromhex(state)
