"""Small grippers of every kind, on an arm of one joint."""

from math import cos, tan
from pathlib import Path
from typing import Any, NamedTuple

import mujoco

from bt_manip.robots import RobotDescription
from bt_manip_setup.finger_travel import FoundFingers, find_fingers

ARM = ("turn",)

_MODEL = """
<mujoco model="rig">
  <compiler angle="radian" autolimits="true"/>
  <default>
    <default class="pad"><geom type="box" size="0.01 0.004 0.01" mass="0.02"/></default>
    <default class="beam"><geom type="box" size="0.005 0.003 0.04" mass="0.02"/></default>
  </default>
  <worldbody>
    <body name="palm" pos="0 0 1">
      <joint name="turn" axis="0 0 1" range="-3 3" damping="0.1" armature="0.1"/>
      <geom type="box" size="0.02 0.06 0.01" pos="0 0 0.01" mass="0.3"/>
      {palm}
      <!--palm-->
    </body>
  </worldbody>
  {rest}
  <actuator>
    <motor name="turn" joint="turn" ctrlrange="-20 20"/>
    {actuators}
  </actuator>
</mujoco>"""


class Kind(NamedTuple):
    """A gripper whose pads of 20 mm end 120 mm from the palm.

    Attributes:
        palm: Elements below the palm.
        rest: Elements beside the worldbody.
        actuators: Its actuators.
        fingers: Bodies of the fingers.
        closed: Minimum opening [m].
        opened: Maximum opening [m].
        motor: Joint or tendon moved by the only motor; None for two motors.
        force: Force of each finger with 20 % for friction [N]; None if unlimited.
        one_moves: Whether one of the fingers is fixed.
        centre: Coordinate of the point where the pads meet, along y [m].
    """

    palm: str
    rest: str = ""
    actuators: str = ""
    fingers: tuple[str, str] = ("left", "right")
    closed: float = 0.0
    opened: float = 0.08
    motor: str | None = None
    force: float | None = None
    one_moves: bool = False
    centre: float = 0.0


def finger(name: str, y: float, joint: str, side: float) -> str:
    """Return a finger whose pad's face is at y [m]; side: 1 for the left, -1 for the right."""
    joint = joint and f'<joint name="{name}_joint" {joint}/>'
    return f"""<body name="{name}" pos="0 {y} 0.03">{joint}
      <geom class="pad" pos="0 {side * 0.004} 0.08"/>
      <geom class="beam" pos="0 {side * 0.009} 0.04"/></body>"""


def slide(low: float, high: float, axis: float = 1.0, more: str = "") -> str:
    """Return the attributes of a slide along y."""
    return f'type="slide" axis="0 {axis} 0" range="{low} {high}" armature="0.05" {more}'


def hinge(y: float, axis: float, low: float, high: float) -> str:
    """Return the attributes of a hinge about x, at a distance beside the pad's face."""
    return f'axis="{axis} 0 0" pos="0 {y} 0" range="{low} {high}" armature="0.002"'


_COUPLED = """<equality><joint joint1="left_joint" joint2="right_joint" polycoef="0 {} 0 0 0"
  solref="0.004 1"/></equality>"""
_SERVO = '<position name="grip" {}="{}" kp="300" forcerange="-35 35"/>'
# The pads of hinged fingers, 80 mm from the hinge, are nearest to each other 4 mm below the tool.
_LEVER = 0.076


def _hinged_force(angle: float) -> float:
    """Return the force of a hinged finger for 1 N m where the lever is longest [N]."""
    return cos(angle) ** 2 / _LEVER


MECHANISMS = {
    # Positive opens, and the position is the distance from the middle.
    "slides": Kind(
        finger("left", 0.0, slide(0.0, 0.04), 1.0) + finger("right", 0.0, slide(0.0, 0.04, -1), -1),
        actuators='<motor name="l" joint="left_joint" ctrlrange="-24 24"/>'
        '<motor name="r" joint="right_joint" ctrlrange="-24 24"/>',
        force=20.0,
    ),
    # One closes with positive positions, both have an offset, and neither has a motor.
    "offset_slides": Kind(
        finger("left", 0.05, slide(-0.04, -0.005), 1.0)
        + finger("right", -0.06, slide(0.02, 0.055), -1.0),
        closed=0.015, opened=0.085, centre=0.0025,
    ),
    "slide_and_hinge": Kind(
        finger("left", 0.0, slide(0.0, 0.04), 1.0)
        + finger("right", 0.0, hinge(0.0, 1.0, 0.0, 0.5), -1.0),
    ),
    "coupled_slides": Kind(
        finger("left", -0.0135, slide(0.021, 0.057), 1.0)
        + finger("right", 0.0135, slide(-0.057, -0.021), -1.0),
        rest=_COUPLED.format(-1), actuators=_SERVO.format("joint", "left_joint"),
        motor="left_joint", closed=0.015, opened=0.087, force=35.0 / 1.2 / 2,
    ),
    "tendon": Kind(
        finger("left", 0.0, slide(0.0, 0.04), 1.0) + finger("right", 0.0, slide(0.0, 0.04, -1), -1),
        rest="""<tendon>
          <fixed name="same" range="-1e-5 1e-5"><joint joint="left_joint" coef="1"/>
            <joint joint="right_joint" coef="-1"/></fixed>
          <fixed name="both"><joint joint="left_joint" coef="0.5"/>
            <joint joint="right_joint" coef="0.5"/></fixed></tendon>""",
        actuators=_SERVO.format("tendon", "both"), motor="both", force=35.0 / 1.2 / 2,
    ),
    "springs": Kind(
        finger("left", 0.0, slide(0.0, 0.04, 1, 'stiffness="50"'), 1.0)
        + finger("right", 0.0, slide(0.0, 0.04, -1, 'stiffness="50"'), -1.0),
        rest=_COUPLED.format(1), actuators=_SERVO.format("joint", "left_joint"),
        # The springs take 4 N of 35 N.
        motor="left_joint", force=(35.0 - 4.0) / 1.2 / 2,
    ),
    "one_slide": Kind(
        finger("left", 0.02, slide(0.0, 0.07), 1.0) + finger("right", 0.02, "", -1.0),
        actuators=_SERVO.format("joint", "left_joint"), motor="left_joint",
        opened=0.07, force=35.0 / 1.2, one_moves=True, centre=0.02,
    ),
    "one_jaw": Kind(
        finger("left", 0.0, hinge(0.0, -1.0, -0.2, 1.0), 1.0) + finger("right", 0.0, "", -1.0),
        actuators=_SERVO.format("joint", "left_joint"), motor="left_joint",
        # Opened farther, the jaw would leave the plane of the tool.
        opened=_LEVER * tan(0.55), force=35.0 / 1.2 * _hinged_force(0.55), one_moves=True,
    ),
    "hinges": Kind(
        finger("left", 0.0, hinge(0.0, -1.0, 0.0, 0.5), 1.0)
        + finger("right", 0.0, hinge(0.0, 1.0, 0.0, 0.5), -1.0),
        rest=_COUPLED.format(1), actuators=_SERVO.format("joint", "left_joint"),
        motor="left_joint", opened=2 * _LEVER * tan(0.5),
        force=35.0 / 1.2 / 2 * _hinged_force(0.5),
    ),
}  # fmt: skip


def rig(kind: Kind) -> str:
    """Return the MJCF of a gripper on an arm of one joint."""
    return _MODEL.format(palm=kind.palm, rest=kind.rest, actuators=kind.actuators)


def model_of(name: str) -> str:
    """Return the MJCF of one of the grippers."""
    return rig(MECHANISMS[name])


def fingers_in(xml: str, **options: Any) -> FoundFingers:
    """Find the fingers of a gripper on an arm of one joint."""
    return find_fingers(mujoco.MjModel.from_xml_string(xml), ARM, **options)


def described_arm(model: Path, **more: Any) -> RobotDescription:
    """Describe the arm of one joint."""
    return RobotDescription(
        name="rig", model=str(model), arm_joints=ARM, home=(0.0,), velocity=(1.0,),
        acceleration=(5.0,), jerk=(100.0,), **more,
    )  # fmt: skip
