"""Reading the objects and cameras of scene files."""

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

from bt_manip import spatial
from bt_manip.cell import CellError, Region, declares, looking_at
from bt_manip.cell.objects import Catalogue
from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.models import is_address
from bt_manip.runner.scene import Fixture
from bt_manip.toml_tables import TomlFile, TomlTable

_PLACE = ("model", "name", "on", "free", "position", "quat_wxyz", "rpy", "region")


class FixtureReader:
    """Reads the tables of objects and cameras; the file collects the problems.

    Attributes:
        fixtures: The objects and cameras, in order.
    """

    def __init__(self, file: TomlFile, catalogue: Catalogue | None) -> None:
        """Begin with none.

        Args:
            file: The file.
            catalogue: Makes the objects to check their parameters; None: no check.
        """
        self.fixtures: list[Fixture] = []
        self._file, self._folder, self._catalogue = file, file.path.parent, catalogue

    def read(self, whole: TomlTable) -> None:
        """Read all of them."""
        attempt = self._file.attempt
        for table in attempt(whole.tables, "objects") or []:
            self._take(self._object(table), table)
        for table in attempt(whole.tables, "cameras") or []:
            self._take(self._camera(table), table)

    def _take(self, fixture: Fixture | None, table: TomlTable) -> None:
        if fixture is None:
            return
        names = [known.name for known in self.fixtures]
        if fixture.name in names:
            error = table.error("name", f"is taken: there is already a '{fixture.name}'")
            self._file.attempt(refuse, error)
        if fixture.on and fixture.on not in names:
            error = table.error(
                "on",
                f"is the name of an object further up, got '{fixture.on}'"
                + did_you_mean(fixture.on, names),
            )
            self._file.attempt(refuse, error)
        self.fixtures.append(fixture)

    def _object(self, table: TomlTable) -> Fixture | None:
        attempt = self._file.attempt
        model = attempt(table.needed_text, "model")
        name = attempt(name_in, table, default=model)
        on = attempt(table.text, "on")
        free = attempt(table.flag, "free")
        region = attempt(self._region, table, on)
        T_wo = attempt(self._pose, table, on) if region is None else pin.SE3.Identity()
        parameters = {key: table.value(key) for key in table.keys() if key not in _PLACE}
        if model is None or name is None:
            return None
        model = self._address(model)
        attempt(self._check_made, table, model, parameters)
        return Fixture(
            model, name, T_wo or pin.SE3.Identity(), parameters, free, on=on or "", region=region
        )

    def _camera(self, table: TomlTable) -> Fixture | None:
        attempt = self._file.attempt
        name = attempt(name_in, table, default="camera")
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
        make = known_part(table, "model", self._catalogue.get, model)
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
        if "on" in table.keys() and not declares(made, "rest_height"):
            raise table.error("on", "is only for what knows how it rests; give a 'position'")


def name_in(table: TomlTable, default: str | None = None) -> str | None:
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


def known_part(table: TomlTable, key: str, find: Callable[..., Any], *arguments: Any) -> Any:
    """Return the part that a key names, or raise an error of the key."""
    try:
        return find(*arguments)
    except BtManipError as error:
        raise table.error(key, f"is wrong: {error}") from error


def refuse(error: BtManipError) -> None:
    """Raise an error."""
    raise error


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
