"""An arm of five joints places what it holds, though it cannot tilt it at will."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bt_manip import build_station as build
from bt_manip import spatial
from bt_manip.behaviours import Grasp, Hover, Lift, PlaceOn, Reach
from bt_manip.cell.objects import Cube
from bt_manip.robots import Tolerance, read_description

FILE = Path(__file__).parents[1] / "robots" / "models" / "five_joints.toml"


@pytest.fixture(scope="session")
def build_station(parts):
    """All tests here stand this robot on the table."""
    tolerance = Tolerance(position=1e-4, rotation=5e-3)
    return lambda: build(parts, robot=replace(read_description(FILE), tolerance=tolerance))


def test_a_cube_is_placed_on_another_one(station, trial):
    assert len(station.robot.q) == 5
    cell, turn = station.cell, 1.0
    cell.remove("cube")
    quat = (np.cos(0.5 * turn), 0.0, 0.0, np.sin(0.5 * turn))
    cell.add(Cube(), spatial.pose((0.3, -0.2, 1.04), quat), name="upper")
    cell.add(Cube(), spatial.pose((0.3, 0.2, 1.04)), name="lower")
    cell.step(50)
    for step in (
        Hover(object="upper", height=0.15),
        Reach(object="upper"),
        Grasp(object="upper"),
        Lift(height=0.1),
        PlaceOn(object="upper", support="lower"),
    ):
        trial(step).tick_until("SUCCESS")
    assert cell.pose("upper").translation[2] > cell.pose("lower").translation[2] + 0.045
