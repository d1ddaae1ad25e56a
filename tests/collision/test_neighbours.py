"""What an arm's joints cannot bring together, and looking at some pairs of geoms only."""

import mujoco
import numpy as np
import pytest

from bt_manip.cell import Cell
from bt_manip.collision import CollisionWorld
from bt_manip.collision.arm_motion import part_of_body
from bt_manip.collision.geom_pairs import comparable
from bt_manip.collision.neighbours import never_touching
from bt_manip.collision.scratch_model import restrict_pairs, scratch_model
from bt_manip.robots import Robot, panda

ARM = """<mujoco><worldbody><body name="base" pos="0 0 1">
  <geom name="column" type="cylinder" size=".05 .2"/>
  <geom name="post" type="box" size=".02 .02 .1" pos="0 .2 .3"/>
  <body name="link" pos="0 0 .3">
    <joint name="turn" axis="0 0 1" range="{range}"/>
    <geom name="beam" type="box" size=".15 .02 .02" pos=".2 0 {height}"/>
    <body name="finger" pos=".4 0 0"><joint name="slide" type="slide"/>
      <geom name="tip" size=".02"/></body>
  </body></body></worldbody></mujoco>"""


def never(model: mujoco.MjModel) -> set[frozenset[str]]:
    """Names of the pairs that the joint 'turn' is found never to bring together."""
    joints = np.array([model.joint("turn").id])
    part = part_of_body(model, joints)[model.geom_bodyid]
    found = never_touching(model, joints, part, comparable(model))
    assert (found == found.T).all()
    return {frozenset((model.geom(i).name, model.geom(j).name)) for i, j in np.argwhere(found)}


def arm(height: float = 0.0, range_of_joint: str = "-90 90") -> mujoco.MjModel:
    """A beam that turns about a column, a post beside it, a finger at its end."""
    text = ARM.format(height=height, range=range_of_joint)
    return mujoco.MjModel.from_xml_string(text)


def test_a_beam_that_turns_above_a_column_never_touches_it():
    assert frozenset(("column", "beam")) in never(arm())


def test_a_beam_that_swings_into_a_post_may_touch_it():
    assert frozenset(("post", "beam")) not in never(arm())


def test_a_beam_whose_joint_ends_before_a_post_never_touches_it():
    assert frozenset(("post", "beam")) in never(arm(range_of_joint="-90 60"))


@pytest.mark.parametrize(("height", "apart"), [(0.1201, True), (0.1199, False)])
def test_a_tenth_of_a_millimetre_above_a_post_is_enough(height, apart):
    assert (frozenset(("post", "beam")) in never(arm(height=height))) == apart


def test_what_fingers_do_is_not_foreseen():
    assert not any("tip" in pair for pair in never(arm()))


def test_the_same_arm_elsewhere_is_not_looked_at_again(monkeypatch):
    first = never(arm(height=0.123))
    measured = []
    distance = mujoco.mj_geomDistance
    monkeypatch.setattr(
        mujoco, "mj_geomDistance", lambda *args: measured.append(1) or distance(*args)
    )
    moved = arm(height=0.123)
    moved.body("base").pos[:] = (0.3, -0.2, 2.0)
    assert never(moved) == first and not measured
    assert never(arm(height=0.124)) == first and measured


def test_only_the_pairs_that_are_asked_for_are_seen(rng):
    cell = Cell()
    cell.add(Robot(panda()), free=False)
    model = cell.model
    own = scratch_model(model, 5.0)  # [m] everything is near
    data = mujoco.MjData(own)

    def seen() -> np.ndarray:
        mujoco.mj_kinematics(own, data)
        mujoco.mj_collision(own, data)
        found = np.zeros((model.ngeom,) * 2, dtype=bool)
        found[data.contact.geom[:, 0], data.contact.geom[:, 1]] = True
        return found | found.T

    everything = seen()
    one, other = rng.random((2, 3, model.ngeom)) < 0.2
    wanted = (one[:, :, None] & other[:, None, :]).any(axis=0)
    wanted |= wanted.T
    restrict_pairs(own, comparable(model) & wanted)
    assert np.array_equal(seen(), everything & wanted)
    assert 10 < (everything & wanted).sum() < everything.sum()


def test_with_more_kinds_of_geoms_than_bits_no_pair_is_left_out():
    spheres = "".join(
        f'<body pos="{0.01 * i} 0 0"><freejoint/><geom size=".01"/></body>' for i in range(40)
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{spheres}</worldbody></mujoco>")
    chain = np.eye(40, k=1, dtype=bool) | np.eye(40, k=-1, dtype=bool)
    own = scratch_model(model, 0.0)
    restrict_pairs(own, np.zeros_like(chain))
    restrict_pairs(own, chain)
    data = mujoco.MjData(own)
    mujoco.mj_kinematics(own, data)
    mujoco.mj_collision(own, data)
    seen = {tuple(pair) for pair in data.contact.geom.tolist()}
    assert seen >= {(i, i + 1) for i in range(39)}


def test_what_moves_as_one_is_not_in_its_own_way():
    cell, robot = Cell(), Robot(panda())
    cell.add(robot, free=False)
    world = CollisionWorld(robot, robot.make_model())
    of_geom = cell.model.geom_bodyid
    hand, finger = (of_geom == cell.body_id(f"panda/{name}") for name in ("hand", "left_finger"))
    link5 = of_geom == cell.body_id("panda/link5")
    assert not world.counts[hand][:, finger].any()
    assert world.counts[link5][:, finger].any()
