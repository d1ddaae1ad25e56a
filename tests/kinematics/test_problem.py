"""Inverse kinematics problems: what they accept."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.kinematics import IKProblem, PoseTarget
from tests.measuring.kinematics import refused

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)
GRIP = PoseTarget("tool", DOWN)


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ({"targets": None}, "a target must be a PositionTarget, .* or PoseTarget, got NoneType"),
        ({"joints": "joint1"}, "a list of names, got 'joint1'"),
        ({"joints": ["joint1", 2]}, r"a list of names, got \['joint1', 2\]"),
        ({"world": 3}, "world must be a CollisionWorld, got int"),
        ({"manipulability": -1.0}, "manipulability must be at least 0, got -1.0"),
        ({"clearance": -1e-3}, "clearance must be at least 0 .m., got -0.001"),
        ({"clearance": 1e-3}, "a clearance of 0.001 m needs a CollisionWorld, got world=None"),
        ({"base": np.eye(4)}, "base must be a pin.SE3, got ndarray"),
        ({"targets": ()}, "it has no targets"),
        ({"targets": [DOWN]}, "a target must be a PositionTarget, .* got SE3"),
        ({"posture": np.zeros(7), "posture_weight": 0.0}, "posture_weight must be above 0"),
    ],
)
def test_invalid_problems_are_refused_when_they_are_made(stated, message):
    refused(lambda: IKProblem(**{"targets": GRIP, **stated}), message)


def test_a_collision_world_has_a_largest_clearance_and_no_base(walled):
    for given, message in (
        ({"clearance": 0.0081}, "clearance must be at most 0.008 m, .* measures, got 0.0081"),
        ({"base": DOWN}, "must not have both a base and a CollisionWorld"),
    ):
        refused(lambda g=given: IKProblem(targets=GRIP, world=walled.world, **g), message)
