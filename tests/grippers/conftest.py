"""The Panda over a cube on a post, built once a module."""

import pytest

from bt_manip.control import Hold
from tests.support.arms import panda_cell


@pytest.fixture(scope="module")
def built_grip():
    """Give the cell, and a function that puts it back to its start."""
    cell, robot, control, gripper = panda_cell()
    q, start = robot.q, (cell.snapshot(), control.get_state(), gripper.get_state())
    entities = dict(cell.entities)

    def restart():
        cell.restore(start[0], lambda entry: entities[entry["name"]])
        control.reference = Hold(q)
        control.set_state(start[1])
        gripper.set_state(start[2])
        return cell, robot, control, gripper

    return restart


@pytest.fixture
def grip(built_grip):
    return built_grip()
