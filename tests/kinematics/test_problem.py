"""Inverse kinematics problems: what they accept."""

import numpy as np
import pytest

from bt_manip import spatial
from bt_manip.exceptions import MotionError
from bt_manip.kinematics import IKProblem, PoseTarget
from tests.measuring.kinematics import refused

DOWN = spatial.pointing_down([0.45, 0.1, 0.3], 0.4)
GRIP = PoseTarget("tool", DOWN)


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        (
            {"targets": 3},
            "a target must be a PositionTarget, RotationTarget or PoseTarget, got int",
        ),
        ({"targets": None}, "got NoneType"),
        ({"targets": "tool"}, "got str"),
        ({"targets": [GRIP, 3]}, "got int"),
        ({"targets": np.array("tool")}, "got ndarray"),
        ({"joints": np.array("joint1")}, "a list of names, got array"),
        ({"joints": 3}, "joints must be a list of names, got 3"),
        ({"joints": "joint1"}, "a list of names, got 'joint1'"),
        ({"joints": ["joint1", 2]}, r"a list of names, got \['joint1', 2\]"),
        ({"world": 3}, "world must be a CollisionWorld, got int"),
        ({"posture_weight": "1"}, "posture_weight must be above 0, got '1'"),
        ({"posture_weight": np.ones(2)}, "posture_weight must be above 0, got array"),
        ({"manipulability": -1.0}, "manipulability must be at least 0, got -1.0"),
        ({"manipulability": np.zeros(2)}, "manipulability must be at least 0, got array"),
        ({"clearance": -1e-3}, "clearance must be at least 0 .m., got -0.001"),
        ({"clearance": "1 mm"}, "clearance must be at least 0 .m., got '1 mm'"),
        ({"clearance": 1e-3}, "a clearance of 0.001 m needs a CollisionWorld, got world=None"),
        ({"base": 3}, "base must be a pin.SE3, got int"),
    ],
)
def test_invalid_problems_are_refused_when_they_are_made(stated, message):
    refused(lambda: IKProblem(**{"targets": GRIP, **stated}), message)


def test_a_clearance_beyond_what_the_world_measures_is_refused_with_the_reason(walled):
    grip = PoseTarget("panda/tool", walled.left)
    for clearance in (0.0081, 0.05):
        refused(
            lambda clearance=clearance: IKProblem(
                targets=grip, world=walled.world, clearance=clearance
            ),
            f"clearance must be at most 0.008 m, .* CollisionWorld measures, got {clearance:g}",
        )


def test_a_base_and_a_collision_world_exclude_each_other(walled):
    with pytest.raises(MotionError, match="must not have both a base and a CollisionWorld"):
        IKProblem(targets=PoseTarget("tool", DOWN), base=DOWN, world=walled.world)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: IKProblem(), "it has no targets"),
        (lambda: IKProblem(targets=[DOWN]), "a target must be a PositionTarget, .* got SE3"),
        (
            lambda: IKProblem(targets=PoseTarget("tool", DOWN), base=np.eye(4)),
            "base must be a pin.SE3, got ndarray",
        ),
        (
            lambda: IKProblem(posture=np.zeros(7), posture_weight=0.0),
            "posture_weight must be above 0",
        ),
        (lambda: IKProblem(manipulability=np.nan), "manipulability must be at least 0, got nan"),
    ],
)
def test_empty_problems_and_invalid_weights_are_refused(make, message):
    refused(make, message)
