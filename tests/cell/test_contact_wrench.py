"""The wrench of contacts, against the generalized forces that MuJoCo applies to a free body."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell, Cube
from bt_manip.spatial import pose


@pytest.mark.parametrize("condim", [3, 6])
def test_force_and_torque_on_a_spinning_cube_are_those_of_mujoco(condim):
    cell = Cell()
    cell.add(Cube(mass=0.5), pose((0.3, 0.2, 0.025)), name="box")
    geoms = cell.contacts.geoms("box")
    cell.model.geom_condim[geoms] = condim
    cell.model.geom_friction[geoms] = (0.8, 0.02, 0.01)
    dof = 0  # of the only free body
    cell.step(20)
    cell.data.qvel[dof : dof + 6] = (0.3, -0.2, 0.0, 0.4, 0.3, 6.0)
    cell.step(1)
    assert cell.contacts.touching("box")
    data, body = cell.data, cell.model.dof_bodyid[dof]
    mujoco.mj_forward(cell.model, cell.data)
    expected = data.qfrc_constraint[dof : dof + 6].copy()
    torque = data.xmat[body].reshape(3, 3) @ expected[3:]  # it is given in the body's axes
    wrench = cell.contacts.wrench("box", point=data.xpos[body])
    assert wrench.force == pytest.approx(expected[:3], rel=1e-6, abs=1e-9)
    assert wrench.torque == pytest.approx(torque, rel=1e-6, abs=1e-9)
    assert abs(torque[2]) > 1e-4
    point = np.array([1.0, -2.0, 0.5])  # about another point: the force has a lever
    moved = torque + np.cross(data.xpos[body] - point, expected[:3])
    assert cell.contacts.wrench("box", point=point).torque == pytest.approx(
        moved, rel=1e-6, abs=1e-9
    )
