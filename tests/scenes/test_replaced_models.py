"""Models of others in the place of objects of a scene."""

from types import SimpleNamespace

import pytest

from bt_manip.cell.objects import Cube, Table
from bt_manip.scenes import two_arms, with_models


def test_a_higher_table_lifts_all_robots_and_objects_that_stand_on_it():
    scene = two_arms()
    made = {"table": Table, "high": lambda category: Table(height=1.215)}
    catalogue = SimpleNamespace(create=lambda model, **values: made.get(model, Cube)(**values))
    lifted = with_models(scene, {"table": "high"}, catalogue)
    before = [one.T_wb for one in scene.robots] + [one.T_wo for one in scene.objects]
    after = [one.T_wb for one in lifted.robots] + [one.T_wo for one in lifted.objects]
    for T_before, T_after in zip(before, after, strict=True):
        rise = 0.2 if T_before.translation[2] > 0.5 else 0.0
        assert T_after.translation - T_before.translation == pytest.approx([0.0, 0.0, rise])
