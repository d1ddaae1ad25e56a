"""Reading and writing of a robot's description as TOML."""

from pathlib import Path

from bt_manip.toml import TomlFile, read_fields

from .errors import RobotError
from .gripper_description import GripperDescription, GripperTable
from .robot_description import RobotDescription


def read_description(path: Path | str) -> RobotDescription:
    """Read a robot's description.

    The keys are declared by `RobotDescription`, and in ``[gripper]`` by `GripperDescription` and
    the parameters of the gripper's kind. A single number applies to every joint.

    Args:
        path: The file; model paths in it are relative to its folder.

    Raises:
        RobotError: If the file is missing, or keys are missing or wrong; the message has a line for
            each of these, with the file and the key.
    """
    path = Path(path)
    given = read_fields(RobotDescription, _file(path).whole)
    return RobotDescription(**{"name": path.stem, **given}, source=str(path))


def read_gripper(path: Path | str) -> GripperDescription | None:
    """Read only the gripper of a robot's description, whatever is wrong with the rest.

    Raises:
        RobotError: If keys of the gripper that all kinds have are missing or wrong.
    """
    file = _file(Path(path))
    gripper = GripperTable().read_table(file.whole.table("gripper"))
    if file.problems:
        raise RobotError("\n".join(map(str, file.problems)))
    return gripper


def _file(path: Path) -> TomlFile:
    return TomlFile(path, "robot description", RobotError)
