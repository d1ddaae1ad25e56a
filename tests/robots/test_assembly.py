from pathlib import Path

import numpy as np
import pytest

from bt_manip.robots import Robot, RobotError, compile_alone
from tests.robot_fixtures import described

TWO_LINK = Path(__file__).parent / "models" / "two_link.urdf"


def test_a_robot_may_be_urdf():
    robot = Robot(described(TWO_LINK))
    compile_alone(robot)
    assert robot.limits.effort.tolist() == [60.0, 30.0]
    assert robot.limits.upper.tolist() == [2.0, 2.5]
    tool = robot.make_model().pose(np.zeros(2)).translation
    assert tool == pytest.approx([0.0, 0.0, 0.85])


def test_urdf_with_a_missing_mesh_names_file_and_line(tmp_path):
    path = tmp_path / "broken.urdf"
    box = '<cylinder radius="0.03" length="0.3"/>'
    path.write_text(TWO_LINK.read_text().replace(box, '<mesh filename="no.stl"/>'))
    with pytest.raises(RobotError, match=r"broken.urdf:\d+: there is no mesh 'no.stl'"):
        Robot(described(path))
