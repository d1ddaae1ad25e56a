"""Maximum reach: no configuration exceeds it, and poses beyond it are refused."""

import pytest

from bt_manip import spatial
from tests.measuring.kinematics import random_configurations


def test_a_pose_beyond_the_reach_is_refused_without_a_search(model, ik):
    found = ik.solve(spatial.pointing_down([2.0, 0.0, 0.3]), model.home)
    assert not found.solved and found.iterations == 0
    assert "m out of reach" in found.reason
    assert found.position_error == pytest.approx(1.7, abs=0.02)


def test_no_configuration_reaches_farther_than_the_maximum_reach(model, ik, rng):
    farthest = 0.0
    for q in random_configurations(model, rng, 3000):
        assert ik.solve(model.pose(q), q, restarts=0).solved
        farthest = max(farthest, ik._reach.distance_at(q))
    assert 0.97 * ik._reach.distance < farthest <= ik._reach.distance + 1e-9
