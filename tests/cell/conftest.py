import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell, Cube, Table
from bt_manip.spatial import pose

SURFACE = 1.015  # [m]


def content(model: mujoco.MjModel) -> bytes:
    """Return all that is compiled."""
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    return buffer.tobytes()


@pytest.fixture(scope="module")
def cell():
    """A light cube on a heavy one on the table."""
    cell = Cell()
    with cell.editing():
        cell.add(Table())
        cell.add(Cube(mass=2.0), pose((0.1, 0.2, SURFACE + 0.025)), name="heavy")
        cell.add(Cube(mass=0.5), pose((0.1, 0.2, SURFACE + 0.075)), name="light")
    cell.step(500)
    return cell
