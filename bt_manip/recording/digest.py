"""A fingerprint of a whole run."""

import hashlib

import mujoco
import numpy as np

_INTEGRATION = mujoco.mjtState.mjSTATE_INTEGRATION


class StateDigest:
    """SHA-256 over the state of the physics and all node statuses after every tick.

    The state is MuJoCo's integration state: all that the next step depends on. So two runs with
    the same digest went through the same states, bit for bit.
    """

    def __init__(self) -> None:
        """Begin with nothing."""
        self._hash = hashlib.sha256()
        self._state = np.empty(0)

    def update(self, model: mujoco.MjModel, data: mujoco.MjData, statuses: bytes) -> None:
        """Take in one tick.

        Args:
            model: The compiled model, which may be another one in each tick.
            data: Its state.
            statuses: One byte for each node of the tree.
        """
        size = mujoco.mj_stateSize(model, _INTEGRATION)
        if self._state.size != size:
            self._state = np.empty(size)
        mujoco.mj_getState(model, data, self._state, _INTEGRATION)
        self._hash.update(self._state.tobytes())
        self._hash.update(statuses)

    def hexdigest(self) -> str:
        """Give the digest of all ticks so far."""
        return self._hash.hexdigest()
