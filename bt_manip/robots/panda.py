"""The Franka Emika Panda with its hand."""

from math import pi

from bt_manip.models import bundled_path

from .gripper_description import GripperDescription
from .robot_description import RobotDescription


def panda() -> RobotDescription:
    """Return the description of the Panda.

    The limits are those of ``rate_limiting.h`` in libfranka and of the robot's data sheet.
    """
    return RobotDescription(
        name="panda",
        model=str(bundled_path("panda/panda.xml")),
        arm_joints=tuple(f"joint{i}" for i in range(1, 8)),
        tool_frame="tool",
        home=(0.0, -pi / 4, 0.0, -3 * pi / 4, 0.0, pi / 2, pi / 4),
        velocity=(2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61),
        acceleration=(15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0),
        jerk=(7500.0, 3750.0, 5000.0, 6250.0, 7500.0, 10000.0, 10000.0),
        gripper=GripperDescription(
            max_force=140.0,
            parameters={
                "joints": ["finger_joint1", "finger_joint2"],
                "fingers": ["left_finger", "right_finger"],
                "open_width": 0.08,
                "max_speed": 0.2,
                "travel": str(bundled_path("panda/finger_travel.toml")),
            },
        ),
    )
