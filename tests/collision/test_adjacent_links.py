"""Pairs of geoms on adjacent links that never collide."""

from itertools import product

import mujoco
import numpy as np
import pytest

from bt_manip.collision.adjacent_links import hull_points, never_colliding_pairs
from bt_manip.collision.collision_model import collidable_pairs
from bt_manip.collision.motion_bounds import link_of_body

ARM = """<mujoco><worldbody><body name="ball" pos="0 0 9"><freejoint/><geom size=".1"/></body>
<body name="base" pos="0 0 1" quat=".9 .1 -.2 .3">
  <geom name="column" type="cylinder" size=".05 .2" pos="-.2 0 0"/>
  <geom name="post" type="box" size=".02 .02 .1" pos="-.2 .33 .3"/>
  <body name="link" pos="-.1 0 .3" euler="0 0 90">
    <joint name="turn" axis="0 0 1" pos="0 .1 0" ref="25" {range}/>
    <geom name="beam" type="box" size=".02 .15 .02" pos="0 -.1 {height}"/>
    <body name="finger" pos="0 -.3 0"><joint name="slide" type="slide"/>
      <geom name="tip" size=".02"/></body>
  </body></body></worldbody></mujoco>"""


def never_colliding(model: mujoco.MjModel) -> set[frozenset[str]]:
    """Return the names of the pairs that never collide, whatever the angle of the joint 'turn'."""
    joints = np.array([model.joint("turn").id])
    link = link_of_body(model, joints)[model.geom_bodyid]
    found = never_colliding_pairs(model, joints, link, collidable_pairs(model))
    assert (found == found.T).all()
    return {frozenset((model.geom(i).name, model.geom(j).name)) for i, j in np.argwhere(found)}


def arm(height: float = 0.0, turn: tuple[float, float] | None = (-90, 90)) -> mujoco.MjModel:
    """Return a beam that turns about a column, with a post beside it and a finger at its end.

    Its body is turned and beside the axis, and the joint is at 25 degrees where it is drawn.
    """
    limits = f'range="{turn[0] + 25} {turn[1] + 25}"' if turn else ""
    return mujoco.MjModel.from_xml_string(ARM.format(height=height, range=limits))


@pytest.mark.parametrize(
    ("other", "height", "turn", "apart"),
    [
        ("column", 0.0, (-90, 90), True),  # the beam turns above it
        ("post", 0.0, (-90, 90), False),  # the beam swings into it
        ("post", 0.0, (-90, 60), True),  # the range ends before it
        ("post", 0.0, (20, 140), False),  # which both ends are away from
        ("post", 0.0, None, False),
        ("post", 0.1201, (-90, 90), True),  # a tenth of a millimetre above it
        ("post", 0.1199, (-90, 90), False),
    ],
)
def test_a_pair_that_no_angle_brings_together_never_collides(other, height, turn, apart):
    found = never_colliding(arm(height, turn))
    assert (frozenset((other, "beam")) in found) is apart
    assert not any("tip" in pair for pair in found)  # the gripper moves it: not examined


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


def test_the_corners_of_a_box_enclose_it():
    model = arm()
    found = hull_points(model, model.geom("beam").id)
    corners = set(product((-0.02, 0.02), (-0.15, 0.15), (-0.02, 0.02)))
    assert len(found) == 8 and set(map(tuple, found.tolist())) == corners
