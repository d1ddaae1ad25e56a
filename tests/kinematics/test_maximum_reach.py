"""Maximum reach: no configuration exceeds it, and poses beyond it are refused."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import spatial
from bt_manip.kinematics import PoseTarget
from bt_manip.kinematics.initial_guesses import InitialGuesses
from bt_manip.kinematics.maximum_reach import MaximumReach
from tests.measuring.kinematics import random_configurations


@pytest.fixture
def reach(model) -> MaximumReach:
    return MaximumReach(model, InitialGuesses(model).stored)


def test_a_pose_beyond_the_reach_is_refused_without_a_search(model, ik):
    found = ik.solve(spatial.pointing_down([2.0, 0.0, 0.3]), model.home)
    assert not found.solved and found.iterations == 0
    assert "m out of reach" in found.reason
    assert found.position_error == pytest.approx(1.7, abs=0.02)


def test_no_configuration_reaches_farther_than_the_maximum_reach(model, ik, reach, rng):
    farthest = 0.0
    for q in random_configurations(model, rng, 1000):
        assert ik.solve(model.pose(q), q, restarts=0).solved
        farthest = max(farthest, reach.distance_at(q))
    assert 0.97 * reach.distance < farthest <= reach.distance + 1e-9


def test_no_target_with_free_rotations_that_the_arm_reaches_is_refused(model, reach, rng):
    refused = 0
    for q in random_configurations(model, rng, 200):
        T, axis, pivot = model.pose(q), rng.normal(size=3), 0.2 * rng.normal(size=3)
        axis /= np.linalg.norm(axis)
        for cone in (0.0, 0.4, 2.0):
            tilt = np.cross(axis, rng.normal(size=3))
            turn = pin.exp3(cone * tilt / np.linalg.norm(tilt)) @ pin.exp3(
                rng.uniform(-3, 3) * axis
            )
            middle = pin.SE3(np.eye(3), pivot)
            turned = T * middle * pin.SE3(turn, np.zeros(3)).inverse() * middle.inverse()
            target = PoseTarget("tool", turned, free_axis=axis, cone=cone, pivot=pivot)
            assert reach.excess(target) == 0.0
            refused += reach.excess(turned) > 0.0
    assert refused > 20


def test_free_rotations_and_tolerances_widen_the_reach(reach):
    # The last joint is 0.107 + 0.1034 m above the tool, the second 0.333 m above the base.
    T, tolerance = spatial.pointing_down([2.0, 0.0, 0.3]), (0.05, 1e-9)
    beside = PoseTarget("tool", T, free_axis="x", tolerance=tolerance)
    tilted = replace(beside, free_axis="z", cone=0.4, pivot=[0.0, 0.0, -0.05])
    for target, height, free in (
        (T, 0.2104, 0.0),
        (beside, 0.0, 0.2104 + 0.05),
        (tilted, 0.05 + 0.1604 * np.cos(0.4), 0.1604 * np.sin(0.4) + 0.05),
    ):
        expected = np.hypot(2.0, 0.3 + height - 0.333) - reach.distance - free
        assert reach.excess(target) == pytest.approx(expected, abs=1e-6)
