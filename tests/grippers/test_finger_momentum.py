"""Heavy fingers do not push an object away; fingers of much friction do not oscillate."""

import numpy as np
import pytest

from bt_manip.grippers import TwoFingerGripper
from bt_manip.grippers.two_finger.fingers import FingerLoop
from bt_manip.grippers.two_finger.stroke import Motion
from tests.control.conftest import panda_cell

MOMENTUM = 0.1  # [N s]


class HeavyFingers(TwoFingerGripper):
    """Fingers with the inertia of a geared motor."""

    ARMATURE = 8.0  # [kg]

    def _build(self, *given, **parameters):
        super()._build(*given, **parameters)
        for joint in self.mechanism.joints:
            joint.armature = self.ARMATURE


def test_after_the_first_contact_the_momentum_of_a_finger_is_limited():
    cell, _, _, gripper = panda_cell(0.015, make_gripper=HeavyFingers)
    dofs = gripper.mechanism.dof_adr
    mass = cell.model.dof_M0[dofs]
    assert (mass > HeavyFingers.ARMATURE).all()
    gripper.close(40.0)
    contact, momenta = None, []
    while not gripper.steady:
        cell.step()
        assert cell.time < 2.0
        if contact is None and any(gripper.forces):
            contact = cell.time
        if contact is not None and cell.time > contact + 0.05:  # slowed down; recoil adds a little
            momenta.append(np.abs(mass * cell.data.qvel[dofs]).max())
    assert 0.9 * MOMENTUM < max(momenta) < 1.3 * MOMENTUM
    assert gripper.held == ("cube",)


class SlowFingers(HeavyFingers):
    """Fingers that cannot brake from the usual speed within 1.5 mm."""

    ARMATURE = 70.0


def test_a_heavy_finger_is_so_slow_that_it_can_stop_within_a_millimetre_and_a_half():
    cell, _, _, gripper = panda_cell(cube=False, make_gripper=SlowFingers)
    gripper.move(0.06)
    widths = [gripper.width]
    while gripper.moving:
        cell.step()
        widths.append(gripper.width)
        assert cell.time < 1.0
    speed = 0.5 * np.abs(np.diff(widths)).max() / cell.dt
    braking = gripper.max_force / cell.model.dof_M0[gripper.mechanism.dof_adr].mean()
    assert speed == pytest.approx(np.sqrt(2.0 * braking * 1.5e-3), rel=0.02)


# Below 2 m p viscous friction is added, for two poles at 150 rad/s; above it all is the finger's.
@pytest.mark.parametrize(
    ("loss", "damping", "stiffness"), [(30.0, 90.0, 0.3 * 150.0**2), (400.0, 400.0, 200.0 * 150.0)]
)
def test_fingers_follow_a_motion_with_two_equal_poles_and_a_bounded_force(loss, damping, stiffness):
    loop = FingerLoop(mass=0.3, loss=loss, moving=16.0)
    assert (loop.damping, loop.stiffness) == pytest.approx((damping, stiffness))
    s, v, a, errors, speeds = 0.03, 0.01, 2.0, (2e-4, -3e-4), (0.012, 0.007)
    expected = [0.3 * a + damping * v + stiffness * e - (damping - loss) * w
                for e, w in zip(errors, speeds, strict=True)]  # fmt: skip
    measured = (s - errors[0], s - errors[1], *speeds)
    assert loop.forces(Motion(s, v, a), measured) == pytest.approx(expected)
    blocked = loop.forces(Motion(s, 0.0, 0.0), (s - 0.1, s + 0.1, 0.0, 0.0))
    assert blocked == pytest.approx((24.0, -24.0))  # half more than for its fastest motion
    weak = FingerLoop(mass=0.3, loss=loss, moving=1.0)
    assert weak.forces(Motion(s, 0.0, 0.0), (s + 0.1, s, 0.0, 0.0)) == (-20.0, 0.0)
    assert weak.forces(Motion(s, 0.0, 0.0), (s, s - 0.1, 0.0, 0.0)) == (0.0, 20.0)
