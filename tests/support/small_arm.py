"""A half-metre arm with six joints and two sliding fingers, as light as hobby arms are."""

from pathlib import Path

MODEL = """
<mujoco model="small">
  <compiler angle="radian" autolimits="true"/>
  <default>
    <joint armature="{armature}" frictionloss="{friction}" damping="{damping}"/>
    <geom type="capsule" size="0.025" density="600"/>
    <motor ctrlrange="-{effort} {effort}" forcerange="-{effort} {effort}"/>
    <default class="finger">
      <joint type="slide" range="0 0.04" armature="0.01" damping="10" frictionloss="0"/>
      <motor ctrlrange="-100 100" forcerange="-100 100"/>
    </default>
    <default class="pad">
      <geom type="box" size="0.01 0.005 0.02" friction="1" solref="0.004 1"/>
    </default>
  </default>
  <worldbody>
    <body name="base">
      <geom type="cylinder" size="0.05 0.03" pos="0 0 0.03"/>
      <body name="shoulder" pos="0 0 0.06">
        <joint name="joint1" axis="0 0 1" range="-3.1 3.1"/>
        <geom type="cylinder" size="0.035 0.025" pos="0 0 0.025"/>
        <body name="upper_arm" pos="0 0 0.06">
          <joint name="joint2" axis="0 1 0" range="-1.9 1.9"/>
          <geom fromto="0 0 0.05 0 0 0.2340"/>
          <body name="forearm" pos="0 0 0.2340">
            <joint name="joint3" axis="0 1 0" range="-2.8 2.8"/>
            <geom fromto="0 0 0.04 0 0 0.1"/>
            <body name="lower_forearm" pos="0 0 0.1080">
              <joint name="joint4" axis="0 0 1" range="-3.1 3.1"/>
              <geom fromto="0 0 0 0 0 0.06" size="0.022"/>
              <body name="wrist" pos="0 0 0.1080">
                <joint name="joint5" axis="0 1 0" range="-2.1 2.1"/>
                <geom fromto="0 0 0.02 0 0 0.03" size="0.02"/>
                <body name="hand" pos="0 0 0.05">
                  <joint name="joint6" axis="0 0 1" range="-3.1 3.1"/>
                  <geom name="palm" type="box" size="0.02 0.05 0.01" pos="0 0 0.015"/>
                  <site name="tool" pos="0 0 0.085"/>
                  <body name="left_finger" pos="0 0 0.075">
                    <joint name="left" class="finger" axis="0 1 0"/>
                    <geom class="pad" pos="0 0.005 0"/>
                    <geom type="box" size="0.01 0.004 0.018" pos="0 0.006 -0.03"/>
                  </body>
                  <body name="right_finger" pos="0 0 0.075">
                    <joint name="right" class="finger" axis="0 -1 0"/>
                    <geom class="pad" pos="0 -0.005 0"/>
                    <geom type="box" size="0.01 0.004 0.018" pos="0 -0.006 -0.03"/>
                  </body>
                </body>
              </body>
            </body>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <contact>
    <exclude body1="base" body2="shoulder"/>
    <exclude body1="hand" body2="left_finger"/>
    <exclude body1="hand" body2="right_finger"/>
    <exclude body1="left_finger" body2="right_finger"/>
  </contact>
  <actuator>
    <motor name="motor1" joint="joint1"/>
    <motor name="motor2" joint="joint2"/>
    <motor name="motor3" joint="joint3"/>
    <motor name="motor4" joint="joint4"/>
    <motor name="motor5" joint="joint5"/>
    <motor name="motor6" joint="joint6"/>
    <motor name="motor7" joint="left" class="finger"/>
    <motor name="motor8" joint="right" class="finger"/>
  </actuator>
</mujoco>
"""

DESCRIPTION = """
model = "small.xml"
arm_joints = ["joint1", "joint2", "joint3", "joint4", "joint5", "joint6"]
home = [0.0, -0.4, 1.9, 0.0, 1.64, 0.0]
velocity = 3.0
acceleration = 10.0
jerk = 500.0

[tool]
frame = "tool"

[tool_limits]
velocity = 1.0
acceleration = 10.0
jerk = 500.0

[gripper]
joints = ["left", "right"]
fingers = ["left_finger", "right_finger"]
open_width = {opening}
max_speed = 0.1
max_force = {force}

# Measured by bt-manip robot measure; the digests are of what it depends on.
[gripper.travel]
open_width = 0.08
min_width = 0.0
polynomials = [[0.0, 1.0], [0.0, 1.0]]
holding = [[0.0], [0.0]]
ratios = [1.0, 1.0]
mass = 0.0
loss = 10.0
friction = 0.0
closing = [0.0, 1.0, 0.0]
centre = [0.0, 0.0]
joints = ["left", "right"]
widths = [0.0, 0.08]
positions = [[0.0, 0.04], [0.0, 0.04]]

[gripper.travel.digests]
bodies = "0f08712a6370d8e4"
joints = "2a9b2c9713af84fa"
couplings = "96e7ae6fca908dd4"
"tool frame" = "802f98af65862e7d"
keys = "48b4e44c8aac2135"
"""


def write_small_arm(
    folder: Path,
    *,
    armature: float = 0.02,
    friction: float = 0.1,
    damping: float = 0.1,
    effort: float = 12.0,
    opening: float = 0.08,
    force: float = 80.0,
) -> Path:
    """Write the model and the description; return the path of the description.

    Args:
        folder: Where to write.
        armature: Rotor inertia of each joint [kg m2].
        friction: Dry friction of each joint [N m].
        damping: Of each joint [N m s/rad].
        effort: Limit of each joint [N m].
        opening: Of the gripper [m].
        force: Maximum of each finger [N].
    """
    model = MODEL.format(armature=armature, friction=friction, damping=damping, effort=effort)
    (folder / "small.xml").write_text(model)
    path = folder / "small.toml"
    path.write_text(DESCRIPTION.format(opening=opening, force=force))
    return path
