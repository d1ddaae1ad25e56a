"""Named configurations, from tables and from MoveIt Pro's waypoints."""

import pytest

from bt_manip.exceptions import BtManipError, MotionError
from bt_manip.robots import load_configurations
from bt_manip.robots.configurations import find_configuration, read_configurations, read_waypoints
from bt_manip.toml import TomlFile

WAYPOINTS = """\
- name: Above
  joint_state:
    name: [finger, arm_joint2, arm_joint1]
    position: [0.1, 2.0, 1.0]
"""
JOINTS = ("joint1", "joint2")


@pytest.fixture
def known(tmp_path):
    (tmp_path / "waypoints.yaml").write_text(WAYPOINTS)
    path = tmp_path / "robot.toml"
    path.write_text(
        'waypoints = "waypoints.yaml"\n[configurations]\nready = [0.5, -1]\none = [1]\n'
    )
    return read_configurations(TomlFile(path, "robot", BtManipError).whole)


def test_configurations_are_found_in_the_order_of_the_joints(known):
    assert find_configuration("ready", known, JOINTS) == (0.5, -1.0)
    assert find_configuration("Above", known, JOINTS) == (1.0, 2.0)


def test_a_waypoint_file_is_a_file_of_configurations(tmp_path):
    for name in ("waypoints.yaml", "waypoints.yml"):
        (tmp_path / name).write_text(WAYPOINTS)
        assert load_configurations(tmp_path / name) == read_waypoints(tmp_path / name)


@pytest.mark.parametrize(
    ("name", "joints", "message"),
    [
        ("redy", JOINTS, "did you mean 'ready'"),
        ("one", JOINTS, "has 1 positions; the arm has 2 joints"),
        ("Above", ("elbow",), "has no joint 'elbow'"),
    ],
)
def test_what_does_not_fit_is_refused(known, name, joints, message):
    with pytest.raises(MotionError, match=message):
        find_configuration(name, known, joints)


@pytest.mark.parametrize("text", ["a: [", "- name: x", "5"])
def test_a_file_that_holds_no_waypoints_is_refused(tmp_path, text):
    (tmp_path / "waypoints.yaml").write_text(text)
    with pytest.raises(BtManipError, match="is no list of waypoints"):
        read_waypoints(tmp_path / "waypoints.yaml")
