"""Named configurations of robots, from TOML tables and MoveIt Pro waypoint files."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from bt_manip.exceptions import BtManipError, MotionError, did_you_mean, one_line
from bt_manip.files import read_text
from bt_manip.toml import MAX_TOML_BYTES, KeyField, TomlFile, TomlTable, plain

from .errors import RobotError

Configuration = Sequence[float] | Mapping[str, float]
"""Joint positions, in joint order or by joint name [rad]."""


class Configurations:
    """Named configurations, in ``[configurations]`` and in the file that ``waypoints`` names."""

    type = "a table of joint positions; `waypoints`: path of a `waypoints.yaml` of MoveIt Pro"
    names = "configurations, waypoints"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> dict[str, Configuration]:
        """Return the configurations by name."""
        return read_configurations(table)

    def write(self, value: Any, entry: KeyField, folder: Path | None) -> dict[str, Any]:
        """Return the table ``[configurations]``."""
        return {entry.name: plain(value)}


def read_configurations(table: TomlTable) -> dict[str, Configuration]:
    """Read the named configurations of a robot or scene file.

    Args:
        table: Root table of the file: ``[configurations]`` has joint positions by name, in joint
            order or by joint [rad]; ``waypoints`` is the path of a MoveIt Pro waypoint file.

    Raises:
        BtManipError: If a configuration is invalid.
    """
    found: dict[str, Configuration] = {}
    waypoints = table.text("waypoints")
    if waypoints is not None:
        folder = table.file.path.parent if isinstance(table.file, TomlFile) else Path()
        try:
            found |= read_waypoints(folder / waypoints)
        except BtManipError as error:
            table.reject("waypoints", f"is wrong: {error}")
    named = table.table("configurations")
    for name in () if named is None else named.keys():
        found[name] = _positions(named, name)  # type: ignore[arg-type]
    return found


def _positions(named: TomlTable, name: str) -> Configuration:
    if not isinstance(named.value(name), dict):
        return named.numbers(name) or ()
    by_joint = named.table(name)
    return {joint: by_joint.number(joint) or 0.0 for joint in by_joint.keys()}  # type: ignore[union-attr]


def load_configurations(path: Path) -> dict[str, Configuration]:
    """Return the named configurations of a file that has nothing else.

    Args:
        path: A TOML file, or a waypoint file of MoveIt Pro (``.yaml``, ``.yml``).

    Raises:
        BtManipError: If the file cannot be read, or has other keys than those of
            `read_configurations`.
    """
    if path.suffix in (".yaml", ".yml"):
        return read_waypoints(path)
    table = TomlFile(path, "file of configurations", RobotError).whole
    found = read_configurations(table)
    table.finish()
    return found


def read_waypoints(path: Path | str) -> dict[str, Configuration]:
    """Read a MoveIt Pro waypoint file: joint positions by joint name.

    Args:
        path: A ``waypoints.yaml``.

    Raises:
        BtManipError: If the file cannot be read or is not a list of waypoints.
    """
    import yaml

    try:
        data = yaml.safe_load(read_text(path, MAX_TOML_BYTES)) or []
        return {
            str(waypoint["name"]): {
                str(joint): float(position)
                for joint, position in zip(
                    waypoint["joint_state"]["name"],
                    waypoint["joint_state"]["position"],
                    strict=True,
                )
            }
            for waypoint in data
        }
    except OSError as error:
        raise BtManipError(f"{path}: {error.strerror}") from None
    except (yaml.YAMLError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise BtManipError(f"{path} is no list of waypoints: {one_line(error)}") from None


def find_configuration(
    name: str, known: Mapping[str, Configuration], joints: Sequence[str]
) -> tuple[float, ...]:
    """Return the joint positions of a named configuration, in the order of the joints [rad].

    Joint names in a waypoint may have a prefix: ``panda_joint1``.

    Args:
        name: Its name.
        known: All named configurations.
        joints: The names of the joints.

    Raises:
        MotionError: If the name is unknown or the configuration is for other joints.
    """
    if name not in known:
        near = did_you_mean(name, known)
        raise MotionError(f"no configuration is named '{name}'{near}", reason="target")
    found = known[name]
    if isinstance(found, Mapping):
        return tuple(_position(name, found, joint) for joint in joints)
    if len(found) != len(joints):
        raise MotionError(
            f"the configuration '{name}' has {len(found)} positions; the arm has {len(joints)} "
            "joints",
            reason="target",
        )
    return tuple(found)


def _position(name: str, positions: Mapping[str, float], joint: str) -> float:
    if joint in positions:
        return positions[joint]
    ending = [value for other, value in positions.items() if other.endswith(joint)]
    if len(ending) != 1:
        raise MotionError(
            f"the configuration '{name}' has no joint '{joint}'; it has {', '.join(positions)}",
            reason="target",
        )
    return ending[0]
