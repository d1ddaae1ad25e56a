"""Stations of the bundled scenes that one test after another runs in."""

from collections.abc import Callable
from typing import Any

from bt_manip.cell.randomization import Randomization
from bt_manip.models import is_address
from bt_manip.plugins import BUILTIN
from bt_manip.registry import Parts, Registry
from bt_manip.runner import RunRequest, Station, make_station
from bt_manip.scenes import Scene, find_scene

KINDS = "objects", "robots", "grippers", "controllers", "planners", "model_sources"
"""Kinds of parts that a station consists of."""

MOST = 8  # stations that are kept


class StationPool:
    """Builds stations, and hands them out again as they were built."""

    def __init__(self) -> None:
        self._kept: list[tuple[Any, Parts, Station, dict[str, Any], Callable[[], None]]] = []
        self._used: list[Station] = []

    def build(self, request: RunRequest, parts: Parts, *, first_cycle: bool = False) -> Station:
        """Return what `make_station` returns, whose arguments these are."""
        scene = find_scene(request.scene, parts)
        names = ("robot", "controller", "planner", "poses", "backend", "seed")
        options = {name: getattr(request, name) for name in names}
        options |= {"first_cycle": first_cycle, "models": list(request.settings.values())}
        key = self._key(parts, scene, options)
        for kept in self._kept:
            known, _, station, start, reset = kept
            if known == key and not any(station is one for one in self._used):
                self._used.append(station)
                self._kept.remove(kept)
                self._kept.insert(0, kept)
                reset()
                station.set_state(start)
                return station
        station = make_station(request, parts, first_cycle=first_cycle)
        if key is not None:
            self._used.append(station)
            kept = (key, parts, station, station.get_state(), _resetter(station))
            self._kept = [kept, *self._kept[: MOST - 1]]
        return station

    def release(self) -> None:
        """Take all stations back."""
        self._used.clear()

    def _key(self, parts: Parts, scene: Scene, options: dict[str, Any]) -> Any:
        """Return what tells stations apart; None for files, which may change."""
        if not isinstance(options["robot"], str):
            return None
        models = options.pop("models")
        files = [options["robot"], *models, *(one.model for one in scene.objects)]
        if (
            options["backend"]
            or scene.source
            or scene.randomization != Randomization()
            or any(map(_is_file, files))
        ):
            return None
        items = [
            (kind, name, _identity(getattr(parts, kind), name))
            for kind in KINDS
            for name in getattr(parts, kind).names()
        ]
        return items, dict(parts.plugins), repr(scene), options


def _identity(registry: Registry[Any], name: str) -> Any:
    """Return what tells a part from others of its name, as long as the parts are kept."""
    item = registry.get(name)
    if registry.owner(name) == BUILTIN:
        return BUILTIN
    return id(item) if callable(item) else repr(item)


def _is_file(name: str) -> bool:
    return is_address(name) or name.endswith(".toml")


def _resetter(station: Station) -> Callable[[], None]:
    """Return a function that resets what is no part of the station's state."""
    configurations = {name: dict(one.robot.configurations) for name, one in station.robots.items()}

    def reset() -> None:
        station.cell.before_remove.clear()
        station.cell.contact_changed.clear()
        for name, one in station.robots.items():
            one.robot.configurations = dict(configurations[name])

    return reset
