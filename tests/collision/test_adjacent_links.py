"""Pairs of geoms on adjacent links that never collide."""

import mujoco
import numpy as np
import pytest

from bt_manip.collision.adjacent_links import never_colliding_pairs
from bt_manip.collision.collision_model import collidable_pairs
from bt_manip.collision.motion_bounds import link_of_body

ARM = """<mujoco><worldbody><body name="base" pos="0 0 1">
  <geom name="column" type="cylinder" size=".05 .2"/>
  <geom name="post" type="box" size=".02 .02 .1" pos="0 .2 .3"/>
  <body name="link" pos="0 0 .3">
    <joint name="turn" axis="0 0 1" range="{range}"/>
    <geom name="beam" type="box" size=".15 .02 .02" pos=".2 0 {height}"/>
    <body name="finger" pos=".4 0 0"><joint name="slide" type="slide"/>
      <geom name="tip" size=".02"/></body>
  </body></body></worldbody></mujoco>"""


def never_colliding(model: mujoco.MjModel) -> set[frozenset[str]]:
    """Return the names of the pairs that never collide, whatever the angle of the joint 'turn'."""
    joints = np.array([model.joint("turn").id])
    link = link_of_body(model, joints)[model.geom_bodyid]
    found = never_colliding_pairs(model, joints, link, collidable_pairs(model))
    assert (found == found.T).all()
    return {frozenset((model.geom(i).name, model.geom(j).name)) for i, j in np.argwhere(found)}


def arm(height: float = 0.0, range_of_joint: str = "-90 90") -> mujoco.MjModel:
    """Return a beam that turns about a column, with a post beside it and a finger at its end."""
    text = ARM.format(height=height, range=range_of_joint)
    return mujoco.MjModel.from_xml_string(text)


def test_a_beam_that_turns_above_a_column_never_collides_with_it():
    assert frozenset(("column", "beam")) in never_colliding(arm())


def test_a_beam_that_swings_into_a_post_may_collide_with_it():
    assert frozenset(("post", "beam")) not in never_colliding(arm())


def test_a_beam_whose_joint_range_ends_before_a_post_never_collides_with_it():
    assert frozenset(("post", "beam")) in never_colliding(arm(range_of_joint="-90 60"))


@pytest.mark.parametrize(("height", "apart"), [(0.1201, True), (0.1199, False)])
def test_a_tenth_of_a_millimetre_above_a_post_is_enough(height, apart):
    assert (frozenset(("post", "beam")) in never_colliding(arm(height=height))) == apart


def test_geoms_that_the_gripper_moves_are_not_examined():
    assert not any("tip" in pair for pair in never_colliding(arm()))


def test_the_result_for_an_arm_is_reused_when_it_is_compiled_elsewhere(monkeypatch):
    first = never_colliding(arm(height=0.123))
    measured = []
    distance = mujoco.mj_geomDistance
    monkeypatch.setattr(
        mujoco, "mj_geomDistance", lambda *args: measured.append(1) or distance(*args)
    )
    moved = arm(height=0.123)
    moved.body("base").pos[:] = (0.3, -0.2, 2.0)
    assert never_colliding(moved) == first and not measured
    assert never_colliding(arm(height=0.124)) == first and measured
