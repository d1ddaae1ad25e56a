"""MuJoCo is the oracle: what it computes for the compiled model is what must come out."""

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from bt_manip.robots import RobotError
from bt_manip.robots.model_building import build_model
from bt_manip_contracts import verify

EXACT = 1e-9

ODD_BODIES = """
<mujoco>
  <compiler angle="radian"/>
  <option gravity="1 -2 -9"/>
  <worldbody>
    <body name="elsewhere" pos="5 5 5"><freejoint/><geom size=".1"/></body>
    <body name="stand" pos=".3 -.2 .7" euler=".4 -.3 .9">
      <frame pos=".1 .2 .3" euler=".1 .2 .3">
        <frame euler="-.5 0 .2">
          <body name="a" pos="0 .1 .4" quat="1 2 3 4">
            <joint name="ja" axis="1 2 -3" pos=".05 -.1 .02" armature=".2"/>
            <inertial mass="2" pos=".1 .2 -.1" fullinertia=".3 .35 .4 .02 -.03 .04"/>
            <site name="on_a" pos=".1 0 0" euler=".3 .2 .1"/>
            <body name="b" pos=".3 0 .1" euler="1 .2 -.4">
              <joint name="jb" type="slide" axis="0 1 1" ref=".2" range="-.4 .6" limited="true"/>
              <geom type="box" size=".1 .2 .05" pos=".1 .1 0" euler=".2 .3 .4"/>
              <body name="c" pos="0 0 .3">
                <joint name="jc1" axis="1 0 0" ref=".3" armature=".01"/>
                <joint name="jc2" axis="0 0 1" pos="0 .1 0" armature=".01"/>
                <geom type="capsule" fromto="0 0 0 0 .2 .3" size=".04"/>
                <site name="tool" pos="0 .2 .3" quat="0 1 0 1"/>
                <body name="massless" pos="0 0 .1">
                  <joint name="finger" type="slide" axis="1 0 0"/>
                  <geom size=".02" mass=".1"/>
                </body>
                <body pos="0 0 .1"><inertial mass=".3" pos=".1 0 0" diaginertia="0 0 0"/></body>
                <body name="dangling" pos=".1 0 0">
                  <joint name="ball" type="ball" pos="0 0 .05"/>
                  <geom size=".03" pos=".1 0 0" mass=".2"/>
                </body>
              </body>
            </body>
          </body>
        </frame>
      </frame>
    </body>
  </worldbody>
  <actuator>
    <motor joint="jb" gear="3" armature=".05"/>
  </actuator>
  <tendon>
    <fixed name="t" armature=".3">
      <joint joint="jc1" coef="-.5"/><joint joint="finger" coef="2"/>
    </fixed>
  </tendon>
</mujoco>
"""
ARM = ["ja", "jb", "jc1", "jc2"]


@pytest.fixture
def odd():
    return mujoco.MjModel.from_xml_string(ODD_BODIES)


def test_odd_poses_frames_inertias_slides_and_references_come_out_exact(odd, rng):
    model = build_model(odd, joints=ARM)
    assert verify(odd, model, rng=rng, n=100).worst < EXACT
    assert np.allclose(model.armature, [0.2, 9 * 0.05, 0.01 + 0.25 * 0.3, 0.01])  # by squares
    assert model.lowerPositionLimit.tolist() == [-np.inf, -0.4, -np.inf, -np.inf]
    assert model.upperPositionLimit.tolist() == [np.inf, 0.6, np.inf, np.inf]
    model.inertias[2] = pin.Inertia.Random()
    assert verify(odd, model, rng=rng, n=5).worst > 1e-3


def test_other_joints_are_locked_where_they_are_asked_to_be(odd, rng):
    qpos = odd.qpos0.copy()
    qpos[odd.joint("finger").qposadr] = 0.07
    ball = odd.joint("ball").qposadr[0]
    qpos[ball : ball + 4] = np.array([1.0, 0.2, -0.4, 0.3]) / np.sqrt(1.29)
    there = build_model(odd, joints=ARM, qpos=qpos)
    assert verify(odd, there, rng=rng, n=20, qpos=qpos).worst < EXACT
    assert verify(odd, build_model(odd, joints=ARM), rng=rng, n=20, qpos=qpos).worst > 1e-3


def test_an_arm_on_an_arm_stands_on_the_locked_one(odd, rng):
    qpos = odd.qpos0.copy()
    qpos[odd.joint("ja").qposadr] = 0.8
    model = build_model(odd, joints=["jb", "jc1"], qpos=qpos)
    assert verify(odd, model, rng=rng, n=20, qpos=qpos).worst < EXACT


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        (["ja", "jc3"], "no joint 'jc3'; did you mean 'jc"),
        (["jb", "ja"], "wrong order"),
        (["ja", "ball"], "ball"),
        (["ja", "ja"], "wrong order"),
    ],
)
def test_joints_that_make_no_arm_are_refused(odd, joints, message):
    with pytest.raises(RobotError, match=message):
        build_model(odd, joints=joints)
    body = '<body name="{0}"><joint name="j{0}"/><geom size=".1"/></body>'
    two = f"<mujoco><worldbody>{body.format('a')}{body.format('b')}</worldbody></mujoco>"
    with pytest.raises(RobotError, match="not below body 'a'"):
        build_model(mujoco.MjModel.from_xml_string(two), joints=["ja", "jb"])


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('joint="finger" coef', 'joint="jb" coef', "tendon #0 couples joints of the arm"),
        ("fixed", "spatial", "tendon #0 has an armature and is spatial"),
        ('motor joint="jb"', 'motor tendon="t"', "actuator #0 has an armature but is not on a"),
    ],
)
def test_armature_that_is_not_of_single_joints_is_refused(old, new, message):
    text = ODD_BODIES.replace(old, new)
    if new == "spatial":
        start, end = text.index("<joint joint="), text.index("</spatial>")
        text = f'{text[:start]}<site site="on_a"/><site site="tool"/>{text[end:]}'
    with pytest.raises(RobotError, match=message):
        build_model(mujoco.MjModel.from_xml_string(text), joints=ARM)


def test_every_arm_of_the_menagerie_is_exact(menagerie, rng):
    checked = 0
    for path in sorted(menagerie.glob("*/*.xml")):
        if path.name == "scene.xml":
            continue
        mj_model = mujoco.MjModel.from_xml_path(str(path))
        joints = [mj_model.joint(i).name for i in range(mj_model.njnt)]
        for some in (joints, joints[:6]):
            model = build_model(mj_model, joints=some)
            assert verify(mj_model, model, rng=rng, n=5).worst < EXACT, path
        checked += 1
    assert checked >= 5
