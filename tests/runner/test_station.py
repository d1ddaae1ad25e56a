"""A station is built by names, and continues from its state bit for bit."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.cell import CellError
from bt_manip.robots import RobotError, panda
from bt_manip.scenes import Scene, SceneRobot


def test_a_station_begins_with_the_robot_at_home_on_the_table_and_the_seed_asked_for(parts):
    station, other = build_station(parts, seed=1), build_station(parts, seed=2)
    assert station.rng.uniform() == np.random.default_rng(1).uniform() != other.rng.uniform()
    assert station.robot.q == pytest.approx(station.robot.description.home)
    assert list(station.cell.objects) == ["table", "basket"]
    assert station.cell.time == 0.0 and not station.arm.moving
    found = station.infrastructure
    assert found["robot"] is station.robot and found["gripper"] is station.gripper
    assert found["arm"] is station.arm and found["controllers"] is station.controllers


def test_a_slower_station_begins_its_motions_at_its_speed(parts):
    arm = build_station(parts, speed=0.25).arm
    assert (arm.speed_factor, arm.follower.speed_scale) == (0.25, 0.25)


@pytest.mark.parametrize(
    ("reach", "scale"), [(1.015, 1.0), (0.975, 1 / 0.975), (0.7, 1 / 0.7), (3, 0)]
)
def test_a_robot_stands_where_an_arm_of_its_reach_does(parts, reach, scale):
    robot = replace(panda(), T_rb=spatial.pose((0.1, -0.05, 0.0)))
    where = spatial.pose((-0.7, 0.4, 0.2), (np.cos(0.4), 0.0, 0.0, np.sin(0.4)))
    model = build_station(parts, scene=Scene((SceneRobot(where),)), robot=robot).arm.model
    scene = Scene((SceneRobot(where, for_reach=reach * model.reach),))
    station = build_station(parts, scene=scene, robot=robot)
    shoulder = station.cell.data.joint("panda/joint1").xanchor[:2]
    if scale:
        assert shoulder == pytest.approx(scale * where.translation[:2])
    else:  # the tool at home is 0.15 m from the origin at least
        out = np.linalg.norm(station.robot.tool_pose.translation[:2] - shoulder)
        assert np.linalg.norm(shoulder) == pytest.approx(out + 0.15)
    base = station.cell.pose("panda").translation
    assert base[2] == pytest.approx(0.2)


def test_a_robot_may_be_described_by_a_file(parts):
    file = Path(__file__).parents[1] / "robots" / "models" / "post.toml"
    station = build_station(parts, robot=str(file))
    assert station.robot.description.name == "post"
    station.gripper.move(0.03)
    station.step_until(lambda: not station.gripper.moving, timeout=2.0)
    assert station.gripper.width == pytest.approx(0.03, abs=5e-4)


def test_a_robot_may_be_given_by_its_description(parts):
    slow = replace(panda(), name="slow", velocity=(0.5,) * 7)
    station = build_station(parts, robot=slow)
    assert station.robot.description is slow
    assert "slow, computed_torque" in station._repr_html_()


def test_a_robot_that_would_start_inside_a_thing_is_named_with_its_link(parts):
    low = replace(panda(), T_rb=spatial.pose((0.0, 0.0, -0.05)))
    with pytest.raises(CellError, match="'panda/link0' would be .* mm inside 'table'"):
        build_station(parts, robot=low)


def test_a_home_in_self_collision_is_refused(parts):
    folded = replace(panda(), home=(0.0, 1.7, 0.0, -3.0, 0.0, 0.1, 0.0))
    with pytest.raises(
        RobotError, match="at home: 'link1' is .* mm inside 'link7'.*another 'home'"
    ):
        build_station(parts, robot=folded)


def test_a_station_continues_from_its_state_bit_for_bit(parts):
    station = build_station(parts, seed=3)
    station.cell.add(station.models.create("cube"), spatial.pose((0.3, 0.1, 1.1)), name="cube")
    station.arm.move_to_pose(spatial.pointing_down((0.3, 0.1, 1.3)))
    station.gripper.close(30.0)
    station.cell.step(120)
    state = station.get_state()
    station.cell.step(300)
    ended, drawn = station.cell.state_bytes(), station.rng.uniform()

    another = build_station(parts, seed=9)
    another.set_state(state)
    another.cell.step(300)
    assert another.cell.state_bytes() == ended
    assert another.rng.uniform() == drawn  # of another seed until then
