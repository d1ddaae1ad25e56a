"""What the guard tolerates, against the Jacobian of MuJoCo; and when an arm is at rest."""

import mujoco
import numpy as np
import pytest

from bt_manip.arm.external_force_guard import INITIAL_MARGIN
from tests.arm.test_external_force_guard import bench as bench
from tests.arm.test_external_force_guard import built as built


@pytest.mark.parametrize("force", [(0.0, 0.0, -15.0), (12.0, 9.0, 0.0)])  # [N]
def test_a_force_at_the_start_is_tolerated_with_its_joint_torques_and_a_margin(bench, force):
    cell, arm = bench.cell, bench.arm
    cell.data.xfrc_applied[bench.hand, :3] = force
    cell.step(800)
    model, data = cell.model, cell.data
    jacobian = np.zeros((3, model.nv))
    mujoco.mj_jac(model, data, jacobian, None, data.xipos[bench.hand], bench.hand)
    dofs = [model.joint(f"panda/joint{i}").dofadr[0] for i in range(1, 8)]
    torques = np.abs(jacobian[:, dofs].T @ force)
    assert torques.max() > 3.0
    arm.guard.begin(arm.model, arm.v, arm.a)
    tolerated = np.array(arm.guard.get_state()["tolerated"]) - arm.guard.thresholds
    slack = INITIAL_MARGIN * (arm.model.friction + 0.1)
    assert np.abs(tolerated - INITIAL_MARGIN * torques).max() < slack.max()
    assert (tolerated <= INITIAL_MARGIN * torques + 0.1).all()


@pytest.mark.parametrize("v", [0.1, -0.1])  # [rad/s]
@pytest.mark.parametrize("joint", [0, 3, 6])
def test_an_arm_that_swings_in_either_direction_is_not_at_rest(bench, joint, v):
    assert bench.arm.at_rest
    dof = bench.cell.model.joint(f"panda/joint{joint + 1}").dofadr[0]
    bench.cell.data.qvel[dof] = v
    assert not bench.arm.at_rest and not bench.arm.undisturbed
