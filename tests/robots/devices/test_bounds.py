"""Bounds of joints and tool, in planning and in the process that speaks to the arm."""

import sys
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from bt_manip import build_station, load_plugins
from bt_manip.exceptions import MotionError
from bt_manip.plugins import PluginSelection
from bt_manip.robots import ArmBounds, DeviceError, Robot, RobotError, panda
from bt_manip.scenes import Scene, SceneRobot, read_scene
from tests.support.program import DEVICES

Z = 0.45  # [m]; at home the tool is at 0.487
SLACK = 1e-3  # [m] that the connection accepts
SCENE = Scene(
    (SceneRobot(pin.SE3.Identity(), bounds=ArmBounds(z=(Z, 2.0), joints={"joint1": (-0.5, 1.0)})),)
)


@pytest.fixture(scope="module")
def station():
    sys.path.append(str(DEVICES))
    choice = PluginSelection(folders=(DEVICES,))
    parts = load_plugins(entry_points=(), choice=choice, warn=lambda text: None).parts
    station = build_station(
        parts, scene=SCENE, backend="fake=0.5", controller="joint_impedance", speed=1.0
    )
    yield station
    station.hardware.close()
    sys.path.remove(str(DEVICES))


def rest(station):
    """Advance until the arm rests; return the lowest position of its tool on the way."""
    arm, heights = station.arm, []

    def rests():
        heights.append(arm.model.pose(station.robot.q).translation[2])
        return not arm.busy and arm.at_rest and not arm.connection.streaming

    station.step_until(rests, steps=10)
    return min(heights)


def lowered(arm, by):
    T = arm.model.pose(arm.q_ref).copy()
    T.translation[2] -= by
    return T


def test_a_joint_is_not_moved_beyond_its_bounds(station):
    with pytest.raises(MotionError, match=r"joint 1 cannot go to 1\.1.* -0\.5000 to 1\.0000 rad"):
        station.arm.move_to_configuration([1.1, *station.arm.q_ref[1:]])
    assert not station.arm.moving


def test_a_motion_whose_tool_leaves_its_bounds_is_refused_and_names_the_axis(station):
    arm = station.arm
    for move in (arm.move_linear, arm.move_to_pose):
        with pytest.raises(MotionError, match=r"leaves its bounds: z of the tool is 0\.4\d\d m"):
            move(lowered(arm, 0.1))
    assert not arm.moving
    arm.move_linear(lowered(arm, 0.03))
    assert rest(station) > Z


@pytest.mark.parametrize(
    ("joint", "by", "steps", "named"),
    [
        (0, -0.6, 2000, "joint 1"),
        (1, 0.2, 2000, "z of the tool"),
        (0, 0.8, 1500, r"speed of the tool, 0\.\d+ m/s"),
    ],
)
def test_the_connection_takes_no_motion_beyond_a_bound(station, joint, by, steps, named):
    arm, s = station.arm, np.linspace(0.0, 1.0, steps)[:, np.newaxis]
    assert arm.tool_speed == 0.25  # the default
    setpoints = np.tile(arm.q_ref, (len(s), 1))
    setpoints[:, [joint]] += by * s**3 * (10.0 - 15.0 * s + 6.0 * s**2)
    with pytest.raises(DeviceError, match=f"exceeds a limit: .*{named}"):
        arm.follower.send(1000, setpoints)  # early enough on a loaded computer
    assert not arm.connection.streaming


def test_a_motion_that_goes_on_beyond_the_bounds_ends_in_the_planned_stop(station):
    arm = station.arm
    limits = arm.model.limits
    arm.model.limits = replace(limits, box=None)  # planned as if there were none
    arm.move_linear(lowered(arm, 0.2), speed=0.1)
    arm.model.limits = limits
    lowest = rest(station)
    assert "z of the tool is 0.4" in arm.fault
    assert Z - SLACK < lowest < Z + 0.05
    assert not arm.problem


def test_bounds_of_joints_narrow_their_limits_and_no_others():
    plain = Robot(panda()).limits
    bounds = ArmBounds(joints={"joint1": (-0.5, 9.0), "joint3": (-9.0, 0.25)})
    limits = Robot(panda(), bounds=bounds).limits
    assert limits.lower.tolist() == [-0.5, *plain.lower[1:]]
    assert limits.upper.tolist() == [*plain.upper[:2], 0.25, *plain.upper[3:]]


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ({"joint8": (0.0, 1.0)}, "there is no joint 'joint8'; did you mean 'joint7'"),
        ({"joint4": (0.0, 1.0)}, "'joint4' has no range left: its position limits are -3.0718 to"),
        ({"joint1": (0.5, 1.0)}, r"home: joint 1 cannot go to 0\.0000 rad"),
    ],
)
def test_impossible_bounds_of_joints_are_refused(joints, message):
    with pytest.raises(RobotError, match=message):
        Robot(panda(), bounds=ArmBounds(joints=joints))


def test_a_scene_file_has_bounds_and_wrong_ones_are_named_with_their_line(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text("[[robots]]\nbounds = { z = [1.02, 2.0], joint1 = [-1.0, 1.0] }\n")
    assert read_scene(file).robots[0].bounds == ArmBounds(
        z=(1.02, 2.0), joints={"joint1": (-1.0, 1.0)}
    )
    for wrong, message in {
        "z = [2.0, 1.02]": r"scene.toml:2.*'z' go from low to high",
        "joint1 = 1.0": r"scene.toml:2.*joint1.*2 numbers",
    }.items():
        file.write_text(f"[[robots]]\nbounds = {{ {wrong} }}\n")
        with pytest.raises(Exception, match=message):
            read_scene(file)
