"""The digest tells runs apart, and only runs that differ."""

import hashlib

import mujoco
import numpy as np

from bt_manip import spatial
from bt_manip.cell import Cell, Cube
from bt_manip.runner import next_digest


def test_it_is_the_chained_hash_of_mujocos_integration_state_and_the_statuses():
    cell, digest, expected = Cell(), b"", b""
    cell.add(Cube(), spatial.pose((0.0, 0.0, 1.0)))
    cell.data.qvel[0] = 0.5
    spec = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(cell.model, spec))
    for statuses in (b"\x01\x02", b"\x01\x03"):
        cell.step()
        digest = next_digest(digest, cell.state_bytes(), statuses)
        mujoco.mj_getState(cell.model, cell.data, state, spec)
        expected = hashlib.sha256(expected + state.tobytes() + statuses).digest()
    assert digest == expected
