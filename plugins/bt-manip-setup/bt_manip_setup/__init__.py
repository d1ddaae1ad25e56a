"""Describe a robot from its model, check a description, show a robot.

Names are imported on first use, since ``bt-manip --help`` imports this package for its hook.
"""

from typing import TYPE_CHECKING

from bt_manip import lazy_exports

if TYPE_CHECKING:
    from .check import check_description as check_description
    from .describe import describe_robot as describe_robot
    from .describe import description_text as description_text
    from .finger_travel import find_fingers as find_fingers
    from .inspection import make_robot as make_robot
    from .inspection import picture as picture
    from .inspection import summary as summary
    from .known_grippers import gripper_names as gripper_names
    from .trial import try_robot as try_robot

__getattr__ = lazy_exports(__name__)
