"""Halts, pushes and contacts in hundreds; it takes minutes."""

import numpy as np
import pytest

from tests.measuring import disturbances
from tests.measuring.drives import drives
from tests.measuring.stops import halts

pytestmark = pytest.mark.soak


def test_500_halts_stay_on_their_paths_and_inside_all_limits_and_are_about_the_fastest_there_are():
    found = halts(500)
    for halt in found:
        assert halt.off <= 1e-3 and halt.used <= 1.0 + 1e-6, halt
        assert halt.ratio <= 1.1, halt


def test_200_pushes_are_noticed_within_20_milliseconds():
    noticed = disturbances.pushes(200)
    assert noticed.soon == 200 and noticed.false == 0


def test_200_contacts_that_nobody_planned_are_noticed_within_20_milliseconds():
    noticed = disturbances.contacts(200)
    assert noticed.soon == 200 and noticed.false == 0


def test_100_motions_that_nothing_disturbs_are_not_stopped():
    assert disturbances.nominal(100) == 0


def test_200_random_scenes_are_driven_through_about_as_fast_as_their_paths_allow():
    pytest.importorskip("toppra")
    found = drives(200)
    driven = [scene for scene in found if not scene.refused]
    assert sum(scene.reached for scene in driven) == 200  # of those that have a way
    assert not any(scene.touched or scene.saturated for scene in driven)
    assert max(scene.error for scene in driven) <= 2e-3
    ratios = [scene.ratio for scene in driven]
    assert np.median(ratios) <= 1.15 and max(ratios) <= 1.4
