"""Planning and external forces, of the Panda and of other arms; it takes minutes."""

from typing import NamedTuple

import numpy as np
import pytest

from bt_manip.plugins import load_plugins
from bt_manip.robots import RobotDescription
from tests.measuring import disturbances
from tests.measuring.executions import execute_scenes
from tests.measuring.scenes import SCALES, free_start, wall

pytestmark = pytest.mark.soak


class Case(NamedTuple):
    """A robot, the scale of its wall scene, and how many cases it gets."""

    robot: RobotDescription
    scale: float
    count: int


@pytest.fixture(params=["panda", *SCALES])
def case(request, monkeypatch) -> Case:
    name = request.param
    if name != "panda":
        pytest.importorskip("bt_manip_menagerie")
        monkeypatch.setenv("MENAGERIE_ROOT", str(request.getfixturevalue("menagerie")))
    robot = load_plugins().parts.robots.get(name)
    return Case(robot, SCALES.get(name, 1.0), 200 if name == "panda" else 20)


def test_path_around_a_wall_is_found_for_every_seed(case):
    planned, left, right = wall(case.robot, case.scale)
    planned.arm.guard = None  # the reference moves alone
    start = free_start(planned, left)
    for seed in range(case.count):
        planned.arm.reset(start)
        planned.arm.move_to_pose(right, rng=np.random.default_rng(seed))
        while planned.arm.moving:
            planned.arm.advance(1e-3)
            assert not planned.arm.world.collisions(planned.arm.q), seed


def test_motions_in_random_scenes_are_nearly_time_optimal(case):
    pytest.importorskip("toppra")
    found = execute_scenes(case.count, case.robot)
    driven = [scene for scene in found if not scene.refused]
    assert len(driven) == case.count  # refused only where there is no path
    for scene in driven:
        assert scene.reached and not scene.touched and not scene.saturated, scene
        assert scene.error <= 2e-3 and scene.ratio <= 1.4, scene
    assert np.median([scene.ratio for scene in driven]) <= 1.15


def test_pushes_and_contacts_are_detected_within_20_milliseconds_and_nothing_else(case):
    count, robot = case.count, case.robot
    for detected in (disturbances.pushes(count, robot), disturbances.contacts(count, robot)):
        assert detected.in_time == count and detected.false == 0
    assert disturbances.undisturbed(count // 2, robot) == 0
