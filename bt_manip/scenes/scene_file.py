"""Scenes by name, and reading them from TOML files."""

import contextlib
import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import CellError, Region, looking_at
from bt_manip.cell.objects import Catalogue
from bt_manip.cell.randomization import Randomization, parse_variation
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.input_files import read_toml
from bt_manip.models import is_address
from bt_manip.registry import Parts
from bt_manip.robots import read_configurations
from bt_manip.toml_tables import TomlFile, TomlTable

from .scene import Fixture, Scene, SceneRobot, find_robot

MAX_TABLES: Mapping[str, int] = {"robots": 16, "objects": 250, "cameras": 250}
"""Most tables of each kind: a scene of 250 free objects takes about 10 s to build."""

_PLACE = ("model", "name", "on", "free", "position", "quat_wxyz", "rpy", "region", "within_reach")
_VARIED = ("objects", "robots", "lights", "cameras", "observations")


class SceneError(BtManipError):
    """A scene file is wrong.

    Attributes:
        problems: All problems, each with file, line and key.
    """

    def __init__(self, message: str, problems: tuple[str, ...] = ()) -> None:
        """Keep the single problems beside the message."""
        super().__init__(message)
        self.problems = problems or (message,)


def is_scene_file(scene: str) -> bool:
    """Tell whether a text is the path of a scene file, not a registered name."""
    return scene.endswith(".toml") or "/" in scene or "\\" in scene


def find_scene(scene: str | Scene, parts: Parts) -> Scene:
    """Return the scene of a name or file.

    Args:
        scene: A registered name, the path of a TOML file, or a scene.
        parts: The registered parts.

    Raises:
        BtManipError: If there is no such scene, or its file is wrong.
    """
    if isinstance(scene, Scene):
        return scene
    return read_scene(scene, parts) if is_scene_file(scene) else parts.scenes.create(scene)


def seed_of(scene: str | Scene, parts: Parts) -> int:
    """Return the seed of a scene; 0 if it has none, or cannot be read.

    Args:
        scene: A registered name, the path of a TOML file, or a scene.
        parts: The registered parts.
    """
    if isinstance(scene, Scene):
        return scene.seed or 0
    if not is_scene_file(scene):
        return (parts.scenes.create(scene).seed or 0) if scene in parts.scenes else 0
    try:
        seed = read_toml(Path(scene)).get("seed", 0)
    except (OSError, ValueError):  # reported when the scene itself is read
        return 0
    return seed if isinstance(seed, int) and seed >= 0 else 0


def scene_of(path: Path) -> Callable[[], Scene]:
    """Return a factory of a file's scene, to register it; the file is read when it is called."""

    def read() -> Scene:
        return read_scene(path)

    with contextlib.suppress(OSError, ValueError):
        read.__doc__ = str(read_toml(path).get("about", ""))
    return read


def read_scene(path: Path | str, parts: Parts | None = None) -> Scene:
    """Read a scene.

    Args:
        path: The file; paths of models and robots in it start from its folder.
        parts: The registered parts; None: names and parameters are not checked.

    Raises:
        SceneError: With all problems, each with file, line, key and what is allowed.
    """
    file = TomlFile(Path(path), "scene", SceneError)
    scene = _Reader(file, parts).read()
    if file.problems or scene is None:
        problems = tuple(dict.fromkeys(str(problem) for problem in file.problems))
        raise SceneError("\n".join(problems), problems)
    return scene


class _Reader:
    """Reads one file and collects all problems."""

    def __init__(self, file: TomlFile, parts: Parts | None) -> None:
        self._file, self._parts = file, parts
        self._folder = file.path.parent
        self._catalogue = (
            None
            if parts is None
            else Catalogue(parts.objects, sources=parts.model_sources, formats=parts.model_formats)
        )
        self._fixtures: list[Fixture] = []
        self._robots: list[str] = []  # their names

    def read(self) -> Scene | None:
        """Read the scene; None or incomplete if there are problems."""
        attempt, whole = self._file.attempt, self._file.whole
        about = attempt(whole.text, "about")
        seed = attempt(self._seed, whole)
        robots = [self._robot(table) for table in self._tables(whole, "robots")]
        self._robots = [robot.name for robot in robots]
        for table in self._tables(whole, "objects"):
            self._add(self._object(table), table)
        for table in self._tables(whole, "cameras"):
            self._add(self._camera(table), table)
        randomization = self._randomization(attempt(whole.table, "randomization"))
        configurations = attempt(read_configurations, whole, self._folder) or {}
        attempt(whole.finish)
        if "robots" not in whole.keys():
            self._refuse(whole, "robots", "is missing: at least one [[robots]] table")
        if self._file.problems:
            return None
        try:
            return Scene(
                robots=tuple(robots), fixtures=tuple(self._fixtures),
                randomization=randomization, seed=seed, about=about or "",
                source=str(self._file.path), configurations=configurations,
            )  # fmt: skip
        except BtManipError as error:
            self._refuse(whole, "robots", f"is wrong: {error}")
            return None

    def _tables(self, whole: TomlTable, key: str) -> list[TomlTable]:
        """Return the tables of a kind; none if there are too many."""
        tables = self._file.attempt(whole.tables, key) or []
        if len(tables) <= MAX_TABLES[key]:
            return tables
        text = f"has {len(tables)} tables; a scene has at most {MAX_TABLES[key]}"
        self._refuse(whole, key, text)
        return []

    def _refuse(self, table: TomlTable, key: str, message: str) -> None:
        """Add a problem."""
        self._file.problems.append(table.error(key, message))

    @staticmethod
    def _seed(table: TomlTable) -> int | None:
        seed = table.whole_number("seed")
        if seed is not None and seed < 0:
            raise table.error("seed", f"is 0 or a positive number, got {seed}")
        return seed

    # Robots

    def _robot(self, table: TomlTable) -> SceneRobot:
        attempt = self._file.attempt
        description = attempt(table.text, "robot")
        if description is not None and description.endswith(".toml"):
            description = str(self._folder / description)
        name = attempt(_name_in, table)
        robot = SceneRobot(
            T_wb=attempt(table.pose) or pin.SE3.Identity(),
            name=name or "",
            description=description,
            controller=attempt(table.text, "controller"),
            planner=attempt(table.text, "planner"),
            for_reach=attempt(table.number, "for_reach"),
        )
        attempt(table.finish)
        if self._parts is not None:
            parts = self._parts
            if robot.description is not None:
                attempt(_known_part, table, "robot", find_robot, robot.description, parts.robots)
            if robot.controller is not None:
                attempt(_known_part, table, "controller", parts.controllers.get, robot.controller)
            if robot.planner is not None:
                attempt(_known_part, table, "planner", parts.planners.get, robot.planner)
        return robot

    # Objects and cameras

    def _add(self, fixture: Fixture | None, table: TomlTable) -> None:
        if fixture is None:
            return
        names = [known.name for known in self._fixtures]
        if fixture.name in names:
            self._refuse(table, "name", f"is taken: there is already a '{fixture.name}'")
        if fixture.on and fixture.on not in names:
            near = did_you_mean(fixture.on, names)
            text = f"is the name of an object further up, got '{fixture.on}'{near}"
            self._refuse(table, "on", text)
        self._fixtures.append(fixture)

    def _object(self, table: TomlTable) -> Fixture | None:
        attempt = self._file.attempt
        model = attempt(table.needed_text, "model")
        name = attempt(_name_in, table, default=model)
        on = attempt(table.text, "on")
        free = attempt(table.flag, "free")
        within_reach = attempt(self._within_reach, table)
        region = attempt(self._region, table, on)
        T_wo = attempt(self._pose, table, on) if region is None else pin.SE3.Identity()
        parameters = {key: table.value(key) for key in table.keys() if key not in _PLACE}
        if model is None or name is None:
            return None
        model = self._address(model)
        attempt(self._check_made, table, model, parameters)
        return Fixture(
            model, name, T_wo or pin.SE3.Identity(), parameters, free, on=on or "", region=region,
            within_reach=within_reach or False,
        )  # fmt: skip

    def _within_reach(self, table: TomlTable) -> bool | str:
        """Read whether, or of which robot, an object is within reach."""
        if not isinstance(table.value("within_reach"), str):
            return bool(table.flag("within_reach"))
        name = table.needed_text("within_reach")
        if name not in self._robots:
            near = did_you_mean(name, self._robots)
            raise table.error("within_reach", f"is true or the name of a robot, got '{name}'{near}")
        return name

    def _camera(self, table: TomlTable) -> Fixture | None:
        attempt = self._file.attempt
        name = attempt(_name_in, table, default="camera")
        target = attempt(table.numbers, "looking_at", 3)
        T_wc = attempt(table.pose)
        if target is not None and T_wc is not None:
            T_wc = attempt(self._looking, table, T_wc.translation, target)
        given = {key: attempt(table.number, key) for key in ("fovy",)}
        given |= {key: attempt(table.whole_number, key) for key in ("width", "height")}
        parameters = {key: value for key, value in given.items() if value is not None}
        attempt(table.finish)
        attempt(self._check_made, table, "camera", parameters)
        if name is None or T_wc is None:
            return None
        return Fixture("camera", name, T_wc, parameters)

    @staticmethod
    def _looking(table: TomlTable, position: np.ndarray, target: tuple[float, ...]) -> pin.SE3:
        for key in ("quat_wxyz", "rpy"):
            if key in table.keys():
                raise table.error(key, "and 'looking_at' say the same twice: one is enough")
        try:
            return looking_at(position, target)
        except CellError as error:
            raise table.error("looking_at", f"is wrong: {error}") from error

    @staticmethod
    def _pose(table: TomlTable, on: str | None) -> pin.SE3:
        """Read a pose; on a support x and y are enough, and a third number is the height above."""
        if on is None:
            return table.pose()
        position = table.numbers("position")
        if position is None or len(position) not in (2, 3):
            raise table.error(
                "position", f"is x and y in the world [m], and the height above '{on}' if any"
            )
        return spatial.pose((*position, 0.0)[:3], table.turn())

    @staticmethod
    def _region(table: TomlTable, on: str | None) -> Region | None:
        region = table.table("region")
        if region is None:
            return None
        for key in ("position", "quat_wxyz", "rpy"):
            if key in table.keys():
                raise table.error(key, "and 'region' both say where it is: one is enough")
        bounds = {key: region.numbers(key, 2) for key in ("x", "y", "z", "yaw")}
        region.finish()
        for key in ("x", "y") if on else ("x", "y", "z"):
            if bounds[key] is None:
                raise region.error(key, "is missing: the lowest and the highest [m]")
        if on and bounds["z"] is not None:
            raise region.error("z", f"follows from what it is on, '{on}'")
        given = {key: pair for key, pair in bounds.items() if pair is not None}
        try:
            return Region(**{"z": (0.0, 0.0), **given})  # type: ignore[arg-type]
        except CellError as error:
            raise table.error("region", f"is wrong: {error}") from error

    def _address(self, model: str) -> str:
        """Resolve a path from the file's folder; names and other addresses stay as they are."""
        if not is_address(model) or ":" in model or Path(model).is_absolute():
            return model
        return str(self._folder / model)

    def _check_made(self, table: TomlTable, model: str, parameters: Mapping[str, Any]) -> None:
        """Make the object to check its parameters."""
        if self._catalogue is None:
            return
        make = _known_part(table, "model", self._catalogue.get, model)
        allowed = _parameter_names(make)
        for key in parameters:
            if allowed is not None and key not in allowed:
                choices = (*_PLACE, *allowed)
                raise table.error(key, f"means nothing{did_you_mean(key, choices)}")
        try:
            made = make(**parameters)
        except (BtManipError, TypeError, ValueError) as error:
            key = next((k for k in parameters if str(error).startswith(k)), "model")
            raise table.error(key, f"is wrong: {error}") from error
        if "on" in table.keys() and not hasattr(made, "rest_height"):
            raise table.error("on", "is only for what knows how it rests; give a 'position'")

    # Randomization

    def _randomization(self, table: TomlTable | None) -> Randomization:
        if table is None:
            return Randomization()
        attempt = self._file.attempt
        found: dict[str, dict[str, dict[str, Any]]] = {}
        for where in _VARIED:
            kind = attempt(table.table, where)
            found[where] = {} if kind is None else self._things(where, kind)
        attempt(table.finish)
        return Randomization() if self._file.problems else Randomization(**found)

    def _things(self, where: str, table: TomlTable) -> dict[str, dict[str, Any]]:
        attempt = self._file.attempt
        found: dict[str, dict[str, Any]] = {}
        for thing in table.keys():
            lines = attempt(table.table, thing)
            if lines is None:
                continue
            found[thing] = {}
            for quantity in lines.keys():
                variation = attempt(_variation, lines, where, thing, quantity)
                if variation is not None:
                    found[thing][quantity] = variation
        return found


def _variation(table: TomlTable, where: str, thing: str, quantity: str) -> Any:
    try:
        variation = parse_variation(table.value(quantity))
        Randomization(**{where: {thing: {quantity: variation}}})
    except CellError as error:
        raise table.error(quantity, f"is wrong: {error}") from error
    return variation


def _name_in(table: TomlTable, default: str | None = None) -> str | None:
    """Read the name of an entity in the cell.

    Args:
        table: Its table.
        default: Its model, whose registered name is the default.
    """
    name = table.text("name")
    if name is None and default is not None and is_address(default):
        raise table.error("name", "is missing: what it is called in the cell")
    name = name or default
    if name is not None and not name.replace("_", "").replace("-", "").isalnum():
        raise table.error("name", f"is made of letters, digits, '_' and '-', got '{name}'")
    return name


def _known_part(table: TomlTable, key: str, find: Callable[..., Any], *arguments: Any) -> Any:
    """Return the part that a key names, or raise an error of the key."""
    try:
        return find(*arguments)
    except BtManipError as error:
        raise table.error(key, f"is wrong: {error}") from error


def _parameter_names(make: Callable[..., Any]) -> list[str] | None:
    """Return the parameters that an object can be made with; None: any."""
    factory = inspect.unwrap(make)
    build = getattr(factory, "_build", factory)
    try:
        parameters = inspect.signature(build).parameters.values()
    except (TypeError, ValueError):
        return None
    if any(p.kind is p.VAR_KEYWORD for p in parameters):
        return list(factory.defaults) if hasattr(factory, "defaults") else None
    return [p.name for p in parameters if p.name not in ("self", "name")]
