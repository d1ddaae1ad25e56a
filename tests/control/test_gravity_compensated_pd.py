"""PD control with gravity compensation."""

import numpy as np

from bt_manip.control import GravityCompensatedPD


def test_the_torque_is_that_of_gravity_and_proportional_to_both_errors(make_arm):
    cell, robot, control = make_arm(GravityCompensatedPD, kp=(100, 10), kd=(7, 3))
    q, still = np.zeros(2), np.zeros(2)
    weight = control.compute(q, still, q, still, still)
    # Centres of mass at 0.2 m and 0.4 + 0.15 m; 2 kg and 1 kg.
    np.testing.assert_allclose(weight, [-9.81 * (2 * 0.2 + 1 * 0.55), -9.81 * 0.15], atol=1e-9)
    pulled = control.compute(q, still, np.array([0.1, 0.2]), np.array([1.0, 2.0]), still)
    np.testing.assert_allclose(pulled - weight, [100 * 0.1 + 7, 10 * 0.2 + 6], atol=1e-9)
