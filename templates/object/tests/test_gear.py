"""The object fulfils the contract of objects, and can be picked."""

import pytest
from bt_manip.behaviours import Grasp, Hover, Lift, Reach
from bt_manip.bt import Sequence
from bt_manip.spatial import pose
from bt_manip_contracts import contracts_of

test_contracts = contracts_of("gear")


def test_it_can_be_picked(trial, cell, parts):
    thing = parts.objects.create("gear")
    surface = cell.pose("table").translation[2] + cell.find("table").surface_height
    name = cell.add(thing, pose((0.35, 0.1, surface + thing.rest_height)))
    steps = [Hover(object=name, height=0.2), Reach(object=name), Grasp(object=name, force=40.0)]
    picking = trial(Sequence(*steps, Lift(height=0.2)))
    picking.tick_until("SUCCESS", timeout=10.0)
    assert cell.pose(name).translation[2] == pytest.approx(surface + 0.2, abs=0.05)
