"""Fields of a report that identify a run."""

import hashlib
import importlib.util
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bt_manip.exceptions import shown

if TYPE_CHECKING:
    from bt_manip.runner import Run


def identify(run: "Run") -> dict[str, Any]:
    """Return the fields of `RunReport` that identify a run, by name."""
    request, station = run.request, run.station
    chosen = [robot.chosen for robot in station.robots.values()]
    robots = dict.fromkeys(str(one.description) for one in chosen)
    files = {"tree": _tree_files(run)}
    scene = str(request.scene)
    for kind, names in (("scene", [scene]), ("robot", robots)):
        files[kind] = [Path(name) for name in names if name.endswith(".toml")]
    return {
        **run.identity,
        **({"varied": dict(request.varied)} if request.varied else {}),
        "faults": request.faults,
        "robot": ", ".join(robots),
        "scene": scene,
        "controller": ", ".join(dict.fromkeys(str(one.controller) for one in chosen)),
        "planner": ", ".join(dict.fromkeys(str(one.planner) for one in chosen)),
        "settings": dict(request.settings),
        "tick_s": request.tick,
        "time_step_s": station.cell.dt,
        "sha256": {kind: _sha256(paths) for kind, paths in files.items() if paths},
    }


def _tree_files(run: "Run") -> list[Path]:
    """Return the files of the tree: with the included ones, or the module of a Python function."""
    document, source = run.tree.document, run.request.tree
    if document is not None:
        return list(document.files)
    if source.path is not None:
        return [source.path]
    spec = importlib.util.find_spec(source.module) if source.module else None
    return [] if spec is None or spec.origin is None else [Path(spec.origin)]


def _sha256(paths: list[Path]) -> str:
    digest = hashlib.sha256()
    for path in paths:
        if path.is_file():  # a module may be built in
            digest.update(path.read_bytes())
    return digest.hexdigest()


def identity_differences(found: Any, expected: Any, key: str = "") -> dict[str, str]:
    """Return the differences of two identities: the name of each value, and both values.

    Args:
        found: The identity, or a value in it.
        expected: The one that is wanted.
        key: Name of the value; those of nested ones follow, separated by spaces.
    """
    if isinstance(found, Mapping) and isinstance(expected, Mapping):
        lines: dict[str, str] = {}
        for name in sorted({*found, *expected}):
            nested = found.get(name), expected.get(name)
            lines |= identity_differences(*nested, f"{key} {name}".strip())
        return lines
    if found == expected:
        return {}
    return {key: f"{key} {shown(found)} instead of {shown(expected)}"}
