"""The dialect of Nav2's trees: what its navigator writes before a tree runs."""

from bt_manip.bt import Dialect, Element, Problems
from bt_manip_nav2 import controls, decorators

NODES = tuple(
    cls
    for module in (controls, decorators)
    for name, cls in vars(module).items()
    if getattr(cls, "__module__", "") == module.__name__ and not name.startswith("_")
)
LEAVES = ("ComputePathToPose", "ComputePathThroughPoses", "FollowPath", "DriveOnHeading")
NAMES = frozenset((*(cls.__name__ for cls in NODES), *LEAVES))
"""Nodes by which a tree is recognised as Nav2's."""

GIVEN = frozenset(("goal", "goals", "goal_update", "goals_update", "robot_pose", "robot_speed"))
"""The goals that the navigators of nav2_bt_navigator write, and what Nav2's nodes get from ROS."""


def is_nav2(root: Element, problems: Problems) -> bool:
    """Return whether a document of version 4 has nodes of Nav2."""
    return root.get("BTCPP_format") == "4" and any(
        element.name in NAMES for element in root.iterate()
    )


NAV2 = Dialect("nav2", "trees of Nav2", given=GIVEN, recognises=is_nav2)
