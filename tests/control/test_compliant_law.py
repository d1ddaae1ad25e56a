"""The springs of a compliant arm, against the equation of a critically damped joint."""

import mujoco
import numpy as np
import pytest

from bt_manip.control import ComputedTorque
from bt_manip.control.pd_law import compliant_torque


@pytest.mark.parametrize("joint", [0, 1])
def test_a_compliant_joint_returns_in_the_time_of_critical_damping_without_overshoot(
    make_arm, joint
):
    cell, robot, control = make_arm(ComputedTorque)
    model, data = cell.model, cell.data
    model.dof_damping[:] = model.dof_frictionloss[:] = 0.0
    rest, limits = robot.q.copy(), control.model.limits.effort
    dofs = [model.joint(name).dofadr[0] for name in ("two_links/shoulder", "two_links/elbow")]
    others = [dof for dof in dofs if dof != dofs[joint]]
    model.dof_armature[others] = 1e6  # the other joint stands still
    robot.set_configuration(rest + 0.05 * (np.arange(2) == joint))
    accelerations = []
    for torque in (0.0, 1.0):  # by one newton metre it accelerates by one over its inertia
        data.qfrc_applied[dofs[joint]] = torque
        mujoco.mj_forward(model, data)
        accelerations.append(data.qacc[dofs[joint]])
    m = 1.0 / (accelerations[1] - accelerations[0])
    strong = (control.model, 1e6 * limits, robot.q, np.zeros(2))  # as soft as the step needs
    pulled, free = (compliant_torque(*strong, robot.q + by) for by in (0.01, 0.0))
    assert (pulled - free)[joint] == pytest.approx(100.0**2 * m * 0.01, rel=1e-6)
    errors, times = [], np.arange(1500) * model.opt.timestep
    for _ in times:
        errors.append(float(robot.q[joint] - rest[joint]))
        torque = compliant_torque(control.model, limits, robot.q, robot.v, rest)
        data.qfrc_applied[dofs] = torque
        data.ctrl[:] = 0.0
        mujoco.mj_step(model, data)
    rate = min(np.sqrt(5.0 * limits[joint] / m), 100.0)
    expected = 0.05 * (1.0 + rate * times) * np.exp(-rate * times)
    assert np.abs(np.array(errors) - expected).max() < 0.05 * 0.03
    assert min(errors) > -1e-4
