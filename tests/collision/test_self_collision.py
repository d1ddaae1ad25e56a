"""Bodies of a robot that touch each other: found, and ignored where the description says so."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from bt_manip import build_station, spatial
from bt_manip.collision import (
    CollisionWorld,
    check_home,
    permanent_self_collisions,
    self_collision,
    self_collisions,
)
from bt_manip.collision.self_collision import SelfCollision
from bt_manip.exceptions import MotionError
from bt_manip.robots import RobotDescription, RobotError
from tests.robot_fixtures import compiled

# The turret overlaps the foot at every angle; the forearm folds into the foot.
FOLDING_ARM = """
<mujoco model="folding">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="foot">
      <geom type="box" size="0.05 0.05 0.05" pos="0 0 0.05"/>
      <body name="arm/turret" pos="0 0 0.1">
        <joint name="arm/turn"/>
        <geom type="cylinder" size="0.03 0.02" mass="1"/>
        <body name="arm/upper" pos="0 0 0.03">
          <joint name="arm/lift" axis="0 1 0" range="-1.5 1.5"/>
          <geom type="capsule" size="0.02" fromto="0 0 0 0 0 0.3" mass="1"/>
          <body name="arm/fore" pos="0 0 0.32">
            <joint name="arm/fold" axis="0 1 0" range="-3.1 3.1"/>
            <geom type="capsule" size="0.02" fromto="0 0 0.05 0 0 0.4" mass="1"/>
            <site name="arm/tip" pos="0 0 0.42"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
OVERLAP = ("foot", "arm/turret")
FOLDED = (0.0, 0.3, 3.1)


@pytest.fixture
def description(tmp_path) -> RobotDescription:
    path = tmp_path / "folding.xml"
    path.write_text(FOLDING_ARM)
    return RobotDescription(
        name="folding",
        model=str(path),
        arm_joints=("arm/turn", "arm/lift", "arm/fold"),
        tool_frame="arm/tip",
        home=(0.0, 0.3, 0.3),
        velocity=(1.0,) * 3,
        acceleration=(5.0,) * 3,
        jerk=(100.0,) * 3,
        effort=(50.0,) * 3,
    )


def world_of(description: RobotDescription) -> CollisionWorld:
    """Return the collision world of a robot that is compiled alone."""
    robot = compiled(description)
    return CollisionWorld(robot, robot.make_model())


def test_bodies_that_touch_at_most_configurations_are_not_permanent(description):
    most = FOLDING_ARM.replace('range="-3.1 3.1"', 'range="2.9 3.1"')
    Path(description.model).write_text(most)
    world = world_of(replace(description, home=FOLDED))
    touching = {one[:2] for one in self_collisions(world, np.array(FOLDED))}
    assert OVERLAP in touching and len(touching) > 1
    assert permanent_self_collisions(world) == [OVERLAP]


def test_excluded_bodies_may_touch_in_planning_and_in_the_physics(description):
    world = world_of(replace(description, exclude=(OVERLAP,)))
    home = np.array(description.home)
    assert self_collisions(world, home) == world.collisions(home) == []
    assert permanent_self_collisions(world) == []
    model, data = world.robot.mj_model, world.robot.mj_data
    data.qpos[:] = home
    mujoco.mj_forward(model, data)
    assert data.ncon == 0


def test_a_home_in_self_collision_is_refused_with_the_line_that_excludes_the_overlap(description):
    with pytest.raises(RobotError) as error:
        check_home(world_of(description))
    assert "self-collision at home: 'foot' is 20.0 mm inside 'arm/turret'" in str(error.value)
    assert 'exclude = [["foot", "arm/turret"]]' in str(error.value)
    assert "'home'" not in str(error.value)


def test_a_home_with_an_avoidable_collision_has_to_be_changed(description):
    description = replace(description, home=FOLDED, exclude=(OVERLAP,))
    with pytest.raises(RobotError, match="inside 'arm/fore'.*another 'home'") as error:
        check_home(world_of(description))
    assert "exclude" not in str(error.value)


def test_an_arm_that_would_touch_itself_or_its_pedestal_fails_at_once(description, parts):
    description = replace(description, exclude=(OVERLAP,), pedestal=(0.8, 0.8, 0.3))
    description = replace(description, T_rb=spatial.pose((0.0, 0.0, 0.3)))
    arm = build_station(parts, robot=description).arm
    for target, own in ((FOLDED, "foot"), ((0.0, 1.2, 1.8), "pedestal")):
        with pytest.raises(MotionError, match=f"'folding/arm/fore' .* inside 'folding/{own}'") as e:
            arm.move_to_configuration(np.array(target))
        assert e.value.reason == "collision"


def test_of_many_pairs_the_deepest_are_listed_and_the_others_counted(description, monkeypatch):
    pairs = [SelfCollision("a", f"b{i}", 0.1 - 0.01 * i) for i in range(7)]
    monkeypatch.setattr(self_collision, "self_collisions", lambda world, q: pairs)
    with pytest.raises(
        RobotError, match=r"100.0 mm inside 'b0'.* 70.0 mm .*3 more pairs"
    ) as raised:
        check_home(world_of(description))
    assert str(raised.value).count("mm inside") == 4
