"""Robot descriptions by name or file."""

from bt_manip.registry import Registry
from bt_manip.robots import RobotDescription, read_description


def find_robot(robot: str, robots: Registry[RobotDescription]) -> RobotDescription:
    """Return the description of a robot.

    Args:
        robot: A registered name, or the path of a TOML file that describes one.
        robots: The registered descriptions.

    Raises:
        BtManipError: If there is no such robot, or its file is invalid.
    """
    return read_description(robot) if robot.endswith(".toml") else robots.get(robot)
