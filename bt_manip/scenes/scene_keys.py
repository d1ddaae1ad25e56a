"""Types of the keys of scene files."""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import Region, looking_at
from bt_manip.cell.objects import Catalogue, object_parameters
from bt_manip.cell.randomization import Randomization, parse_variation
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.models import is_address
from bt_manip.registry import Parts, Registry
from bt_manip.robots import ArmBounds, RobotDescription, read_description
from bt_manip.toml import KeyField, TomlFile, TomlTable, entries_of, read_part

from .levels import VARIED_KINDS, Level


class SceneError(BtManipError):
    """A scene file is invalid.

    Attributes:
        problems: All problems, each with file, line and key; by default the message.
    """

    def __init__(self, message: str, problems: tuple[str, ...] = ()) -> None:
        super().__init__(message)
        self.problems = problems or (message,)


class SceneFile(TomlFile):
    """A scene file, and the registered parts to which its keys refer; without, none are checked.

    Raises:
        SceneError: If there is no such file or it is not valid TOML.
    """

    def __init__(self, path: Path, parts: Parts | None) -> None:
        super().__init__(path, "scene", SceneError)
        self.parts = parts
        self.catalogue = None
        if parts is not None:
            self.catalogue = Catalogue(
                parts.objects, sources=parts.model_sources, formats=parts.model_formats
            )

    def joined(self, problems: Any) -> BtManipError:
        """Return one error with all problems, sorted by line."""
        texts = tuple(sorted(map(str, problems), key=self._line))
        return SceneError("\n".join(texts), texts)

    def _line(self, problem: str) -> int:
        line = problem.removeprefix(f"{self.path}:").partition(":")[0]
        return int(line) if line.isdigit() else 0


def find_robot(
    robot: str | RobotDescription, robots: Registry[RobotDescription]
) -> RobotDescription:
    """Return the description of a robot.

    Args:
        robot: A registered name, the path of a description file, or a description.
        robots: The registered descriptions.

    Raises:
        BtManipError: If there is no such robot, or its file is invalid.
    """
    if isinstance(robot, RobotDescription):
        return robot
    return read_description(robot) if str(robot).endswith(".toml") else robots.get(robot)


class EntityName:
    """Name of an entity in the cell."""

    type = "a name"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> str | None:
        """Return the name."""
        name = table.text(entry.name)
        if name is None or name.replace("_", "").replace("-", "").isalnum():
            return name
        table.reject(entry.name, f"is made of letters, digits, '_' and '-', got '{name}'")
        return None


class ObjectName(EntityName):
    """Name of an object; by default the registered name of its model."""

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> str | None:
        """Return the name."""
        model = table.text("model")
        if entry.name in table.keys() or model is None or not is_address(model):
            return super().read(table, entry, size) or model
        table.reject(entry.name, "is missing: what it is called in the cell")
        return None


class PartName(NamedTuple):
    """Name of a registered part."""

    kind: str
    type: str = "a registered name"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> str | None:
        """Return the name."""
        name, parts = table.text(entry.name), _file(table).parts
        if name is not None and parts is not None:
            _attempt(table, entry.name, getattr(parts, self.kind).get, name)
        return name


class RobotAddress:
    """Registered name of a robot, or path of its description."""

    type = "a registered name or path.toml"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> str | None:
        """Return the name, or the path with the folder of the file."""
        text, parts = table.text(entry.name), _file(table).parts
        if text is not None and text.endswith(".toml"):
            text = str(_file(table).path.parent / text)
        if text is not None and parts is not None:
            _attempt(table, entry.name, find_robot, text, parts.robots)
        return text


class ObjectModel:
    """Registered name of an object, or address of a model."""

    type = "a registered name or an address"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> str | None:
        """Return the name, or the address with the folder of the file."""
        model = table.text(entry.name)
        if not model or not is_address(model) or ":" in model or Path(model).is_absolute():
            return model
        return str(_file(table).path.parent / model)


class PlacedPose:
    """A pose in the world; on a support x, y and optionally the height above it."""

    type, names = "a pose", "position, quat_wxyz or rpy"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> pin.SE3:
        """Return the pose; the identity with a region."""
        if "region" in table.keys():
            for key in ("position", "quat_wxyz", "rpy"):
                if key in table.keys():
                    table.reject(key, "and 'region' exclude each other: give one of them")
            return pin.SE3.Identity()
        on = table.text("on")
        if on is None:
            return table.pose()
        position = table.numbers("position") or ()
        if len(position) not in (2, 3):
            table.reject(
                "position",
                f"is x and y in the world, and optionally the height above '{on}' [m]",
            )
        return spatial.pose((*position, 0.0, 0.0, 0.0)[:3], table.turn())


class CameraPose:
    """A pose in the world, or a position and a point to look at."""

    type, names = "a pose", "position, looking_at, quat_wxyz or rpy"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> pin.SE3:
        """Return the pose."""
        target, T_wc = table.numbers("looking_at", 3), table.pose()
        if target is None:
            return T_wc
        for key in ("quat_wxyz", "rpy"):
            if key in table.keys():
                table.reject(key, "and 'looking_at' exclude each other: give one of them")
        return _attempt(table, "looking_at", looking_at, T_wc.translation, target) or T_wc


class WithinReach:
    """Whether an object is within reach of the first robot, or the name of the robot."""

    type = "true or a robot's name"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> bool | str | None:
        """Return the flag or the name."""
        if isinstance(table.value(entry.name), str):
            return table.text(entry.name)
        return table.flag(entry.name)


class RegionTable:
    """A region; on a support, its height follows from the support."""

    type, cls = "a table", Region

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Region | None:
        """Return the region."""
        part = table.table(entry.name)
        if part is None:
            return None
        on = table.text("on")
        if on is None:
            part.require("z", "2 numbers [m]")
        elif "z" in part.keys():
            part.reject("z", f"follows from the support '{on}': leave it out")
        return _attempt(table, entry.name, read_part, Region, part, z=(0.0, 0.0))


class BoundsTable:
    """Bounds of a robot's motions."""

    type, cls = "a table", ArmBounds

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> ArmBounds | None:
        """Return the bounds."""
        part = table.table(entry.name)
        return None if part is None else _attempt(table, entry.name, read_part, ArmBounds, part)


class RandomizationTable:
    """Variations, by kind of element, name and quantity."""

    type, names = "tables", "randomization"

    def read(self, table: TomlTable, entry: KeyField, size: Any) -> Randomization | None:
        """Return the variations."""
        part = table.table(entry.name)
        return None if part is None else _randomization(part)


class LevelsTable:
    """Levels of the randomization, by name and number."""

    type, names = "tables", "levels"

    def read(
        self, table: TomlTable, entry: KeyField, size: Any
    ) -> dict[str, dict[int, Level]] | None:
        """Return the levels."""
        found: dict[str, dict[int, Level]] = {}
        for name, numbered in _tables(table.table(entry.name)):
            for number, part in _tables(numbered):
                if not number.isdecimal():
                    numbered.reject(number, "is no level: levels are numbers from 0")
                    continue
                keys = part.table("settings")
                settings = {} if keys is None else {k: str(keys.value(k)) for k in keys.keys()}
                varied = _randomization(part) or Randomization()
                found.setdefault(name, {})[int(number)] = Level(varied, settings)
        return found


def _randomization(part: TomlTable) -> Randomization | None:
    """Return the variations of a table, by kind of element, name and quantity."""
    found: dict[str, dict[str, dict[str, Any]]] = {}
    for kind in VARIED_KINDS:
        for thing, lines in _tables(part.table(kind)):
            for quantity in lines.keys():
                varied = _attempt(lines, quantity, _variation, lines, kind, thing, quantity)
                found.setdefault(kind, {}).setdefault(thing, {})[quantity] = varied
    part.finish()
    return None if _file(part).problems else Randomization(**found)


def _tables(table: TomlTable | None) -> Iterator[tuple[str, TomlTable]]:
    """Yield the tables in a table, by key."""
    for key in () if table is None else table.keys():
        part = table.table(key)  # type: ignore[union-attr]
        if part is not None:
            yield key, part


def _variation(table: TomlTable, kind: str, thing: str, quantity: str) -> Any:
    variation = parse_variation(table.value(quantity))
    Randomization(**{kind: {thing: {quantity: variation}}})
    return variation


def check_object(table: TomlTable, model: str, parameters: Mapping[str, Any], cls: type) -> None:
    """Check an object's model and parameters by creating it; reject wrong keys.

    Keys of `cls`, the dataclass of its table, are suggested for mistyped parameters.
    """
    catalogue = _file(table).catalogue
    if catalogue is None or (make := _attempt(table, "model", catalogue.get, model)) is None:
        return
    allowed = object_parameters(make)
    unknown = [key for key in parameters if allowed is not None and key not in allowed]
    for key in unknown:
        keys = [name for known in entries_of(cls) for name in known.names]
        table.reject(key, f"means nothing{did_you_mean(key, (*keys, *(allowed or ())))}")
    if unknown:
        return
    try:
        made = make(**parameters)
    except (BtManipError, TypeError, ValueError) as error:
        key = next((k for k in parameters if str(error).startswith(k)), "model")
        table.reject(key, f"is wrong: {error}")
        return
    if "on" in table.keys() and not hasattr(made, "rest_height"):
        table.reject("on", "is only for objects with a height at rest; give a 'position'")


def _file(table: TomlTable) -> SceneFile:
    assert isinstance(table.file, SceneFile)
    return table.file


def _attempt(
    table: TomlTable, key: str, call: Callable[..., Any], *given: Any, **named: Any
) -> Any:
    """Return the value of a call; on a `BtManipError` reject the key and return None."""
    try:
        return call(*given, **named)
    except BtManipError as error:
        table.reject(key, f"is wrong: {error}")
        return None
