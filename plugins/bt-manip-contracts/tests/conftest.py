"""More situations: for behaviours that set things down on others, or move back."""

import pytest

from bt_manip import spatial
from bt_manip.behaviours import MoveLinear
from bt_manip.testing import play

AROUND_THE_CUBE = "around the cube"
HOLDING = "holding a cube over the table"
AFTER_A_MOTION = "after a motion"
BESIDE_ANOTHER = "holding a cube, another on the table"

LONG = {
    "goes on from its state": {
        "Drop", "FollowTarget", "PlaceAt", "PlaceOn", "gravity_compensated_pd",
        "scene two_arms", "scene varied_pick", "tree pick_place_cluttered", "tree two_arms",
    },
    "halts in every state": {
        "BackOff", "Drop", "FollowTarget", "Hover", "Lift", "MoveArc", "MoveHome", "MoveLinear",
        "MoveThrough", "MoveToPose", "PlaceAt", "PlaceOn", "Reach", "Retreat",
    },
    "runs the same again": {"FollowTarget", "PlaceAt", "PlaceOn"},
}  # fmt: skip
"""Parts by check that takes tenths of a second for each."""


@pytest.fixture
def situations(situations):
    situations.add(BESIDE_ANOTHER, put_another, after=HOLDING)
    move = MoveLinear(pose="0.4;-0.05;1.4;0;1;0;0")
    situations.add(AFTER_A_MOTION, lambda station: play(station, move))
    return situations


def put_another(station):
    cube = station.models.create("cube")
    station.cell.add(cube, spatial.pose((0.35, -0.15, 1.04)), name="other")
    station.cell.step(100)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items):
    """Leave the long checks to soak, but for one part of each kind."""
    for item in items:
        names = item.name.partition("[")[2].removesuffix("]")
        part, _, check = names.rpartition(": ")
        if part in LONG.get(check, ()):
            item.add_marker("soak")
