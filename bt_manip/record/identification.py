"""Identity of what is run: the request, the versions, and the contents of all that was loaded."""

import hashlib
import sys
import sysconfig
from collections.abc import Iterator, Mapping
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from bt_manip.exceptions import shown

if TYPE_CHECKING:
    from bt_manip.runner import Run

_LOADED = ("sha256", "modules")
"""Fields with the SHA-256 of what was loaded, by name."""

_INSTALLED = ("/site-packages/", "/dist-packages/")
_LIBRARY = sysconfig.get_path("stdlib") + "/"
_PLUGIN_FILE = "_bt_manip_plugin_"  # of names of modules
_PROGRAMS = ("__main__", "__mp_main__")

_known: dict[str, tuple[ModuleSpec | None, str]] = {}
"""SHA-256 of modules when they were first seen, by name; empty for installed ones."""


def identify(run: "Run") -> dict[str, Any]:
    """Return the fields of `RunReport` that identify a run, by name.

    ``sha256`` has the files that were read, by their names without folders, so that it holds where
    they are moved; ``modules`` has the Python modules of no installed package, such as plugins in a
    folder and what the module of a tree imports. Installed plugins count by their versions.
    """
    request, station = run.request, run.station
    chosen = [robot.chosen for robot in station.robots.values()]
    robots = dict.fromkeys(str(one.description) for one in chosen)
    return {
        **run.identity,
        "varied": dict(request.varied),
        "modifiers": {name: [*texts] for name, texts in request.modifiers.items()},
        "robot": ", ".join(robots),
        "scene": str(request.scene),
        "controller": ", ".join(dict.fromkeys(str(one.controller) for one in chosen)),
        "planner": ", ".join(dict.fromkeys(str(one.planner) for one in chosen)),
        "settings": dict(request.settings),
        "tick_s": request.tick,
        "time_step_s": station.cell.dt,
        "speed": request.speed_factor,
        "tool_speed": request.tool_speed,
        "poses": request.poses,
        "plugins": dict(station.parts.plugins),
        "sha256": run.all_files,
        "modules": dict(_modules()),
    }


def _modules() -> Iterator[tuple[str, str]]:
    """Yield name and SHA-256 of each imported module that is in no installed package."""
    for name, module in [*sys.modules.items()]:
        if name in _PROGRAMS or name.partition(".")[0] == "bt_manip":
            continue
        spec = getattr(module, "__spec__", None)
        before, digest = _known.get(name, (None, ""))
        if spec is None or spec is not before:  # new, or reloaded
            _known[name] = spec, (digest := _digest(module))
        if digest:
            yield name.removeprefix(_PLUGIN_FILE), digest


def _digest(module: ModuleType) -> str:
    """Return the SHA-256 of the file of a module; empty if it is installed or has none."""
    file = getattr(module, "__file__", None) or ""
    if file.startswith(_LIBRARY) or any(folder in file for folder in _INSTALLED):
        return ""
    return hashlib.sha256(Path(file).read_bytes()).hexdigest() if Path(file).is_file() else ""


def identity_differences(found: Any, expected: Any, key: str = "") -> dict[str, str]:
    """Return the differences of two identities: the name of each value, and both values.

    Files and modules that only one of them has loaded are no difference: what names them, such as a
    tree or a setting, then differs, too.

    Args:
        found: The identity, or a value in it.
        expected: The one that is wanted.
        key: Name of the value; those of nested ones follow, separated by spaces.
    """
    if isinstance(found, Mapping) and isinstance(expected, Mapping):
        lines: dict[str, str] = {}
        names = {*found} & {*expected} if key in _LOADED else {*found, *expected}
        for name in sorted(names):
            nested = found.get(name), expected.get(name)
            lines |= identity_differences(*nested, f"{key} {name}".strip())
        return lines
    if found == expected:
        return {}
    kind, _, name = key.partition(" ")
    if kind in _LOADED and name:
        return {key: f"{name} differs (SHA-256 {found[:8]} instead of {expected[:8]})"}
    if kind in _LOADED:
        return {key: f"the {kind} of what was loaded, by name, are in only one of both"}
    return {key: f"{key} {shown(found)} instead of {shown(expected)}"}
