"""Other arms than the Panda: planning and external forces; it takes minutes."""

import numpy as np
import pytest

from bt_manip.plugins import load_plugins
from bt_manip.robots import RobotDescription
from tests.measuring import disturbances
from tests.measuring.executions import execute_scenes
from tests.measuring.scenes import SCALES, free_start, wall

pytestmark = pytest.mark.soak
COUNT = 20


@pytest.fixture(params=SCALES)
def arm(request, menagerie, monkeypatch) -> RobotDescription:
    pytest.importorskip("bt_manip_menagerie")
    monkeypatch.setenv("MENAGERIE_ROOT", str(menagerie))
    return load_plugins().parts.robots.get(request.param)


def test_path_around_a_wall_is_found_for_every_seed(arm):
    planned, left, right = wall(arm, SCALES[arm.name])
    planned.arm.guard = None  # the reference moves alone
    start = free_start(planned, left)
    for seed in range(COUNT):
        planned.arm.reset(start)
        planned.arm.move_to_pose(right, rng=np.random.default_rng(seed))
        while planned.arm.moving:
            planned.arm.advance(1e-3)
            assert not planned.arm.world.collisions(planned.arm.q)


def test_motions_in_random_scenes_are_nearly_time_optimal(arm):
    pytest.importorskip("toppra")
    found = execute_scenes(COUNT, arm)
    driven = [scene for scene in found if not scene.refused]
    assert len(driven) == COUNT  # refused only where there is no path
    for scene in driven:
        assert scene.reached and not scene.touched and not scene.saturated, scene
        assert scene.error <= 2e-3 and scene.ratio <= 1.4, scene
    assert np.median([scene.ratio for scene in driven]) <= 1.15


def test_pushes_and_contacts_are_detected_and_nothing_else(arm):
    for detected in (disturbances.pushes(COUNT, arm), disturbances.contacts(COUNT, arm)):
        assert detected.in_time == COUNT and detected.false == 0
    assert disturbances.undisturbed(COUNT // 2, arm) == 0
