"""The robot: its model, and limits that MJCF cannot express."""

from math import pi
from pathlib import Path

from bt_manip.grippers import two_finger_gripper
from bt_manip.robots import RobotDescription


def gear():
    """Return the description, with limits from the data sheet."""
    return RobotDescription(
        name="gear",
        model=str(Path(__file__).parent / "gear.xml"),
        arm_joints=("base", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3"),
        tool_frame="tool",
        home=(0.0, -0.4, 1.4, 0.57, -pi / 2, 0.0),
        velocity=(3.0,) * 6,
        acceleration=(10.0,) * 6,
        jerk=(5000.0,) * 6,
        gripper=two_finger_gripper(
            joints=("left_slide", "right_slide"),
            fingers=("left_finger", "right_finger"),
            open_width=0.08,
            max_speed=0.2,
            max_force=80.0,
            travel=str(Path(__file__).parent / "travel.toml"),
        ),
    )
