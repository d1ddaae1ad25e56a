"""The digest tells runs apart, and only runs that differ."""

import hashlib

import mujoco
import numpy as np
import pytest

from bt_manip.recording.digest import StateDigest

FALLING = """
<mujoco><worldbody><body pos="0 0 1"><freejoint/><geom size="0.1"/></body></worldbody></mujoco>
"""


@pytest.fixture
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(FALLING)


def run(model: mujoco.MjModel, *, push: float = 0.0, statuses: bytes = b"\x01") -> str:
    data = mujoco.MjData(model)
    data.qvel[0] = push
    digest = StateDigest()
    for _ in range(3):
        mujoco.mj_step(model, data)
        digest.update(model, data, statuses)
    return digest.hexdigest()


def test_the_same_run_has_the_same_digest(model):
    assert run(model) == run(model)


def test_the_last_bit_of_a_velocity_changes_it(model):
    assert run(model, push=0.0) != run(model, push=5e-324)


def test_the_status_of_a_node_changes_it(model):
    assert run(model, statuses=b"\x01\x02") != run(model, statuses=b"\x01\x03")


def test_it_is_the_hash_of_the_integration_state_and_the_statuses(model):
    data = mujoco.MjData(model)
    spec = mujoco.mjtState.mjSTATE_INTEGRATION
    state = np.empty(mujoco.mj_stateSize(model, spec))
    mujoco.mj_getState(model, data, state, spec)
    digest = StateDigest()
    digest.update(model, data, b"\x01")
    assert digest.hexdigest() == hashlib.sha256(state.tobytes() + b"\x01").hexdigest()


def test_models_of_different_size_follow_each_other(model):
    other = mujoco.MjModel.from_xml_string("<mujoco/>")
    digest = StateDigest()
    for each in (model, other, model):
        digest.update(each, mujoco.MjData(each), b"")
    assert len(digest.hexdigest()) == 64
