"""The digest tells runs apart, and only runs that differ."""

import hashlib

import mujoco
import numpy as np
import pinocchio as pin

from bt_manip.cell import Cell, Cube
from bt_manip.runner import next_digest


def falling(push: float = 0.0) -> Cell:
    cell = Cell()
    cell.add(Cube(), pin.SE3(np.eye(3), np.array([0.0, 0.0, 1.0])))
    cell.data.qvel[0] = push
    return cell


def run(*, push: float = 0.0, statuses: bytes = b"\x01") -> str:
    cell, digest = falling(push), b""
    for _ in range(3):
        cell.step()
        digest = next_digest(digest, cell.state_bytes(), statuses)
    return digest.hex()


def test_it_tells_the_last_bit_of_a_velocity_and_the_status_of_a_node():
    digests = run(), run(push=5e-324), run(statuses=b"\x01\x02"), run(statuses=b"\x01\x03")
    assert len({*digests}) == 4 and run() == digests[0]


def test_it_is_the_hash_of_mujocos_integration_state_and_the_statuses():
    cell = falling(0.5)
    cell.step()
    digest = next_digest(b"", cell.state_bytes(), b"\x01")
    spec = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(cell.model, spec))
    mujoco.mj_getState(cell.model, cell.data, state, spec)
    assert digest.hex() == hashlib.sha256(state.tobytes() + b"\x01").hexdigest()
