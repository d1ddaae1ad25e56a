"""What composer lets one observe of an object is what the cell says of it."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell, Cube
from bt_manip.cell.objects import Can
from bt_manip.spatial import pose


def test_observables_are_the_pose_the_velocity_and_the_contact_force_of_an_object():
    cell = Cell()
    with cell.editing():
        cell.add(Cube(mass=0.5), pose((0.1, 0.0, 0.025)))
        cell.add(Can(), pose((0.3, -0.2, 2.0), (0.9, 0.1, 0.2, 0.3)))  # its origin is its bottom
    cell.step(200)
    cell.data.qvel[6:] = (0.3, -0.2, 0.4, 3.0, -2.0, 1.0)
    mujoco.mj_forward(cell.model, cell.data)
    for name, force in (("cube", (0.0, 0.0, 0.5 * 9.81)), ("can", np.zeros(3))):
        seen = cell.find(name).observables
        T_seen = pose(seen.position(cell.physics), seen.quat_wxyz(cell.physics))
        assert T_seen.isApprox(cell.pose(name), 1e-9)
        assert seen.velocity(cell.physics) == pytest.approx(cell.velocity(name), abs=1e-9)
        assert seen.contact_force(cell.physics) == pytest.approx(force, rel=1e-2, abs=1e-2)
