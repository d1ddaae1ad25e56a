"""Hundreds of pushes and contacts; it takes minutes."""

import numpy as np
import pytest

from tests.measuring import disturbances
from tests.measuring.executions import execute_scenes

pytestmark = pytest.mark.soak


def test_200_pushes_are_detected_within_20_milliseconds():
    detected = disturbances.pushes(200)
    assert detected.in_time == 200 and detected.false == 0


def test_200_contacts_with_unknown_obstacles_are_detected_within_20_milliseconds():
    detected = disturbances.contacts(200)
    assert detected.in_time == 200 and detected.false == 0


def test_100_undisturbed_motions_are_not_stopped():
    assert disturbances.undisturbed(100) == 0


def test_motions_in_200_random_scenes_are_nearly_time_optimal():
    pytest.importorskip("toppra")
    found = execute_scenes(200)
    driven = [scene for scene in found if not scene.refused]
    assert sum(scene.reached for scene in driven) == 200  # all that have a path
    assert not any(scene.touched or scene.saturated for scene in driven)
    assert max(scene.error for scene in driven) <= 2e-3
    ratios = [scene.ratio for scene in driven]
    assert np.median(ratios) <= 1.15 and max(ratios) <= 1.4
