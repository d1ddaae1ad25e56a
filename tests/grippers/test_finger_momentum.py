"""Heavy fingers meet an object so slowly that they do not push it away."""

import numpy as np
import pytest

from bt_manip.grippers import TwoFingerGripper
from tests.control.conftest import panda_cell

MOMENTUM = 0.1  # [N s]


class HeavyFingers(TwoFingerGripper):
    """Fingers with the inertia of a geared motor."""

    ARMATURE = 8.0  # [kg]

    def _build(self, *given, **parameters):
        super()._build(*given, **parameters)
        for joint in self.mechanism.joints:
            joint.armature = self.ARMATURE


@pytest.mark.parametrize("offset", [0.015, -0.015])
def test_after_the_first_contact_the_momentum_of_a_finger_is_limited(offset):
    cell, _, _, gripper = panda_cell(offset, make_gripper=HeavyFingers)
    dofs = gripper.mechanism.dof_adr
    mass = cell.model.dof_M0[dofs]
    assert (mass > HeavyFingers.ARMATURE).all()
    gripper.close(40.0)
    contact = None
    while not gripper.steady:
        cell.step()
        assert cell.time < 2.0
        if contact is None and any(gripper.forces):
            contact = cell.time
        if contact is not None and cell.time > contact + 0.05:  # slowed down; recoil adds a little
            assert np.abs(mass * cell.data.qvel[dofs]).max() < 1.3 * MOMENTUM
    assert gripper.held == ("cube",)
