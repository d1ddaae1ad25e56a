"""Robot, controllers and objects are the same system in a plain composer environment."""

import mujoco
import numpy as np
import pytest
from dm_control import composer

from .conftest import Wave, panda_cell

LIFT = np.array([0.0, -0.1, 0.0, 0.0, 0.0, 0.0, 0.1])  # up from the post, turning
STEPS = 450  # [ms]


def test_the_motion_under_control_gives_the_same_state_bits_and_the_grippers_observables():
    cell, robot, control, gripper = panda_cell()
    control.reference = Wave(robot.q, LIFT, 6.0, delay=0.38)
    gripper.close()
    cell.step(STEPS)
    assert gripper.steady
    for legacy_step in (True, False):
        other, robot, control, gripper = panda_cell()
        home = robot.q
        gripper.observables.enable_all()
        environment = composer.Environment(
            composer.NullTask(other.arena), random_state=0, legacy_step=legacy_step
        )
        environment.reset()
        control.reference = Wave(home, LIFT, 6.0, delay=0.38)
        gripper.close()
        idle = np.zeros(environment.physics.model.nu)
        for _ in range(STEPS):
            seen = environment.step(idle).observation
        fingers = environment.physics.data.qpos[gripper.mechanism.qpos_adr]
        expected = {"forces": gripper.forces, "width": gripper.width, "positions": fingers}
        for name, value in expected.items():
            shown = np.ravel(seen[f"panda/two_finger_gripper/{name}"])
            assert shown == pytest.approx(np.ravel(value))
        kind = mujoco.mjtState.mjSTATE_INTEGRATION
        model, data = environment.physics.model.ptr, environment.physics.data.ptr
        state = np.empty(mujoco.mj_stateSize(model, kind))
        mujoco.mj_getState(model, data, state, kind)
        assert state.tobytes() == cell.state_bytes()
