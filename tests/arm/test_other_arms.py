"""Nothing here knows that an arm is a Panda."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip.arm import Arm
from bt_manip.exceptions import MotionError
from bt_manip.robots import Robot, RobotDescription, compile_alone, panda
from bt_manip.trajectories import limit_use

UR = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
ARMS = {
    "universal_robots_ur5e/ur5e.xml": ("{}_joint", UR, "attachment_site"),
    "kuka_iiwa_14/iiwa14.xml": ("joint{}", range(1, 8), "attachment_site"),
    "franka_fr3/fr3.xml": ("fr3_joint{}", range(1, 8), "attachment_site"),
    "ufactory_xarm7/xarm7.xml": ("joint{}", range(1, 8), "link_tcp"),
}


@pytest.mark.parametrize("file", ARMS)
def test_another_arm_moves_and_stays_inside_its_limits(menagerie, rng, file):
    pattern, numbers, site = ARMS[file]
    names = tuple(pattern.format(i) for i in numbers)
    n = len(names)
    robot = Robot(
        RobotDescription(
            name="other",
            model=str(menagerie / file),
            arm_joints=names,
            tool_frame=site,
            home=(0.1,) * n,
            velocity=(2.0,) * n,
            acceleration=(6.0,) * n,
            jerk=(3000.0,) * n,
            effort=(200.0,) * n,
        )
    )
    compile_alone(robot)
    arm = Arm(robot)
    limits = arm.model.limits
    lower, upper = np.maximum(limits.lower, -2.5), np.minimum(limits.upper, 2.5)
    arm.reset(np.clip(arm.q, lower, upper))
    lines = 0
    for _ in range(8):
        arm.move_to_configuration(rng.uniform(lower, upper))
        trajectory = arm.trajectory
        assert limit_use(trajectory, limits).inside
        while arm.moving:
            arm.advance(1e-3)
        T = arm.model.pose(arm.q)
        target = T * pin.SE3(pin.exp3(np.array([0.1, 0.0, 0.1])), np.array([0.0, 0.05, 0.05]))
        try:
            arm.move_linear(target)
        except MotionError as error:
            assert error.reason == "line"
            continue
        lines += 1
        while arm.moving:
            arm.advance(1e-3)
        assert np.abs(pin.log6(target.actInv(arm.model.pose(arm.q))).np).max() < 1e-5
    assert lines >= 4


def test_an_arm_whose_jerk_is_scarce_goes_on_after_any_pause(rng):
    robot = Robot(replace(panda(), jerk=(60.0,) * 7))
    compile_alone(robot)
    arm = Arm(robot)
    lower, upper = arm.model.limits.lower + 0.1, arm.model.limits.upper - 0.1
    for _ in range(2):
        arm.reset(arm.model.home)
        arm.move_to_configuration(rng.uniform(lower, upper))
        arm.advance(0.2)
        arm.move_to_configuration(target := rng.uniform(lower, upper))
        for _ in range(int(rng.integers(1, 600))):
            arm.advance(1e-3)
        arm.pause()
        while arm.moving:
            arm.advance(1e-3)
        arm.resume()
        rest = 0
        while arm.busy and rest < 20000:
            arm.advance(1e-3)
            rest += 1
        assert np.array_equal(arm.q, target)
