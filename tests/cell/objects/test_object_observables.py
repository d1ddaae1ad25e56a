"""What composer lets one observe of an object is what the cell says of it."""

import numpy as np
import pytest
from dm_control import composer

from bt_manip.cell import Cell, Cube
from bt_manip.spatial import pose


def observe(cell, name, steps):
    thing = cell.find(name)
    for observable in ("position", "quat_wxyz", "velocity", "contact_force"):
        getattr(thing.observables, observable).enabled = True
    environment = composer.Environment(
        composer.NullTask(cell.arena), strip_singleton_obs_buffer_dim=True, random_state=0
    )
    seen = environment.reset().observation
    for _ in range(steps):
        seen = environment.step(np.zeros(0)).observation
    return {key.removeprefix(f"{name}/"): value for key, value in seen.items()}


def test_a_resting_cube_is_pressed_by_its_weight_and_a_falling_one_moves_as_the_cell_says():
    cell = Cell()
    cell.add(Cube(mass=0.5), pose((0.1, 0, 0.025)))
    seen = observe(cell, "cube", 200)
    assert seen["contact_force"] == pytest.approx((0, 0, 0.5 * 9.81), rel=1e-2, abs=1e-2)
    assert seen["position"] == pytest.approx((0.1, 0, 0.025), abs=1e-3)
    assert seen["velocity"] == pytest.approx(np.zeros(6), abs=1e-3)
    quat = np.array((0.9, 0.1, 0.2, 0.3))
    cell = Cell()
    cell.add(Cube(), pose((0, 0, 2), tuple(quat)))
    seen = observe(cell, "cube", 100)
    assert seen["velocity"][2] == pytest.approx(-9.81 * 0.1, rel=2e-2)
    assert seen["quat_wxyz"] == pytest.approx(quat / np.linalg.norm(quat), abs=1e-9)
    assert seen["contact_force"] == pytest.approx(np.zeros(3))
