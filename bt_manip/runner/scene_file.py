"""Reading scenes from TOML files."""

from pathlib import Path
from typing import Any

import pinocchio as pin

from bt_manip.cell import CellError
from bt_manip.cell.objects import Catalogue
from bt_manip.cell.randomization import Randomization, parse_variation
from bt_manip.exceptions import BtManipError
from bt_manip.registry import Parts
from bt_manip.runner.robot_choice import find_robot
from bt_manip.runner.scene import Scene, SceneRobot
from bt_manip.runner.scene_fixtures import FixtureReader, known_part, name_in, refuse
from bt_manip.toml_tables import TomlFile, TomlTable

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

    def read(self) -> Scene | None:
        """Read the scene; None or incomplete if there are problems."""
        attempt, whole = self._file.attempt, self._file.whole
        about = attempt(whole.text, "about")
        seed = attempt(self._seed, whole)
        robots = [self._robot(table) for table in attempt(whole.tables, "robots") or []]
        fixtures = FixtureReader(self._file, self._catalogue())
        fixtures.read(whole)
        randomization = self._randomization(attempt(whole.table, "randomization"))
        attempt(whole.finish)
        if "robots" not in whole.keys():
            attempt(refuse, whole.error("robots", "is missing: at least one [[robots]] table"))
        if self._file.problems:
            return None
        return attempt(
            self._scene,
            robots=tuple(robots), fixtures=tuple(fixtures.fixtures), randomization=randomization,
            seed=seed, about=about or "", source=str(self._file.path),
        )  # fmt: skip

    def _catalogue(self) -> Catalogue | None:
        parts = self._parts
        return None if parts is None else Catalogue(parts.objects, sources=parts.model_sources)

    def _scene(self, **parts: Any) -> Scene:
        try:
            return Scene(**parts)
        except BtManipError as error:
            raise self._file.whole.error("robots", f"is wrong: {error}") from error

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
        name = attempt(name_in, table)
        robot = SceneRobot(
            T_wb=attempt(table.pose) or pin.SE3.Identity(),
            name=name or "",
            description=description,
            controller=attempt(table.text, "controller"),
            planner=attempt(table.text, "planner"),
        )
        attempt(table.finish)
        if self._parts is not None:
            parts = self._parts
            if robot.description is not None:
                attempt(known_part, table, "robot", find_robot, robot.description, parts.robots)
            if robot.controller is not None:
                attempt(known_part, table, "controller", parts.controllers.get, robot.controller)
            if robot.planner is not None:
                attempt(known_part, table, "planner", parts.planners.get, robot.planner)
        return robot

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
