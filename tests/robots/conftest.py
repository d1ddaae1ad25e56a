import numpy as np
import pytest

from bt_manip.grippers import TwoFingerGripper
from bt_manip.robots import Robot, RobotModel, compile_alone, panda


@pytest.fixture
def robot() -> Robot:
    robot = Robot(panda(), gripper=TwoFingerGripper)
    compile_alone(robot)
    return robot


@pytest.fixture
def model(robot: Robot) -> RobotModel:
    return robot.make_model()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)
