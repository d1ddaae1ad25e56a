import numpy as np
import pytest

from bt_manip.motion import Arm, InverseKinematics
from bt_manip.robots import Robot, RobotModel, compile_alone, panda


@pytest.fixture(scope="session")
def compiled_robot() -> Robot:
    robot = Robot(panda())
    compile_alone(robot)
    return robot


@pytest.fixture(scope="session")
def prepared_ik(compiled_robot: Robot) -> InverseKinematics:
    return InverseKinematics(compiled_robot.make_model())


@pytest.fixture
def robot(compiled_robot: Robot) -> Robot:
    """Give the robot at home: tests here only ever set its configuration."""
    compiled_robot.set_configuration(np.array(compiled_robot.description.home))
    return compiled_robot


@pytest.fixture
def model(robot: Robot) -> RobotModel:
    return robot.make_model()


@pytest.fixture
def ik(prepared_ik: InverseKinematics) -> InverseKinematics:
    return prepared_ik


@pytest.fixture
def arm(robot: Robot, ik: InverseKinematics) -> Arm:
    return Arm(robot, ik=ik)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(1)
