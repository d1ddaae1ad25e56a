"""The behaviour ends as specified, and fulfils the contract of behaviours."""

import pytest
from bt_manip.cell.objects import Cube
from bt_manip.spatial import pose
from bt_manip_contracts import Example, contracts_of

from bt_manip_gear.gear import Gear

test_contracts = contracts_of(
    "gear",
    examples={
        "Gear": Example(
            ports={"object": "cube"},
            start="around the cube",
            fails=({"object": "nothing_is_called_so"},),
        )
    },
)


@pytest.fixture
def cube(cell):
    """Drop a cube from 5 cm."""
    surface = cell.pose("table").translation[2] + cell.find("table").surface_height
    cube = Cube()
    return cell.add(cube, pose((0.35, 0.25, surface + cube.rest_height + 0.05)))


def test_it_waits_until_the_object_lies_still(trial, cell, cube):
    waiting = trial(Gear(object=cube))
    cell.step(50)  # it falls
    assert waiting.tick().name == "RUNNING"
    waiting.tick_until("SUCCESS")
    assert abs(cell.velocity(cube)[:3]).max() <= 1e-3


def test_it_gives_up_when_that_takes_too_long(trial, cell, cube):
    waiting = trial(Gear(object=cube, patience=0.05))
    cell.step(20)
    waiting.tick_until("FAILURE")
    assert "still moves" in waiting.behaviour.feedback_message
