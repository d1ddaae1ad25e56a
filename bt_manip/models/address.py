"""Addresses of models, and the files that they refer to."""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.models.bundled import bundled_path, bundled_root
from bt_manip.models.errors import ModelError
from bt_manip.models.menagerie import menagerie_file
from bt_manip.models.model_config import MODEL_CONFIG, sdf_file
from bt_manip.models.packages import find_package_file
from bt_manip.models.progress import Progress, terminal_progress

SUFFIXES = {
    ".sdf": "sdf", ".world": "sdf", ".urdf": "urdf",
    ".obj": "mesh", ".stl": "mesh", ".dae": "mesh",
}  # fmt: skip
"""Formats by suffix; the format of XML files follows from their root element."""

_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")  # a single letter is a drive


@dataclass(frozen=True)
class FoundModel:
    """Local file of a model.

    Attributes:
        address: Address of exactly this model, with its version or absolute path.
        name: Name of the model.
        path: The file.
        format: ``"mjcf"``, ``"urdf"``, ``"sdf"`` or ``"mesh"``.
        root: Folder outside which a downloaded model may not refer to files; None for the user's
            own files.
    """

    address: str
    name: str
    path: Path
    format: str
    root: Path | None = None


def is_address(text: str) -> bool:
    """Return whether a text is an address, and not a registered name."""
    return not all(c.isalnum() or c in "_-" for c in text)


Source = Callable[[str, Progress], FoundModel | Path]
"""Function that finds the model of an address; it may return a path."""


def find_model(
    address: str,
    progress: Progress = terminal_progress,
    sources: Mapping[str, Source] | None = None,
) -> FoundModel:
    """Find a model by its address, and download it if it is not cached.

    Args:
        address: ``bundled:cube``, a path, ``package://NAME/PATH``, ``menagerie:NAME``,
            ``fuel:OWNER/NAME`` with or without a version, or the URL of a model on Fuel.
        progress: Called with the progress of a download.
        sources: Functions that find models, by the kind of address; default: `built_in_sources`.

    Raises:
        ModelError: When there is no such model, or it cannot be fetched.
    """
    text = address.strip()
    match = _SCHEME.match(text)
    scheme = match.group(1).lower() if match else ""
    known = built_in_sources() if sources is None else sources
    if not scheme or (scheme not in known and scheme != "file" and Path(text).exists()):
        return _file(text, Path(text))
    if scheme == "file":
        return _file(text, Path(text[len("file:") :].removeprefix("//")))
    if scheme not in known:
        near = did_you_mean(f"{scheme}:", (f"{other}:" for other in known))
        raise ModelError(f"'{address}': unknown kind of address '{scheme}:'{near}")
    found = known[scheme](text, progress)
    if isinstance(found, Path):
        return replace(_file(str(found), found), address=text)
    return found


def built_in_sources() -> dict[str, Source]:
    """Return the built-in sources, by kind of address."""
    return {
        "bundled": lambda address, progress: _bundled(_rest(address)),
        "fuel": _fuel,
        "http": _fuel,
        "https": _fuel,
        "menagerie": _menagerie,
        "package": lambda address, progress: _file(address, find_package_file(address)),
    }


def _rest(address: str) -> str:
    return address.partition(":")[2]


def _menagerie(address: str, progress: Progress) -> FoundModel:
    rest = _rest(address)
    path = menagerie_file(rest, progress)
    return FoundModel(f"menagerie:{rest}", _name(rest.partition("/")[0]), path, "mjcf")


def _bundled(name: str) -> FoundModel:
    stem = name.removesuffix(".xml")
    inside = f"{stem}.xml" if "/" in stem else f"{stem}/{stem}.xml"
    try:
        path = bundled_path(inside)
    except BtManipError:
        near = did_you_mean(stem, bundled_names())
        raise ModelError(f"no bundled model '{name}'{near}") from None
    return FoundModel(f"bundled:{name}", _name(path.stem), path, "mjcf")


def bundled_names() -> list[str]:
    """Return the names of the models in the package."""
    files = bundled_root("models").glob("*/*.xml")
    return sorted(path.stem for path in files if path.stem == path.parent.name)


def _fuel(text: str, progress: Progress) -> FoundModel:
    from bt_manip.models.fuel.address import fuel_address
    from bt_manip.models.fuel.client import FuelClient

    found, folder = FuelClient(progress=progress).find(fuel_address(text))
    return FoundModel(str(found), _name(found.name), sdf_file(folder), "sdf", folder)


def _file(address: str, path: Path) -> FoundModel:
    path = path.expanduser()
    if path.is_dir() and (path / MODEL_CONFIG).is_file():
        found = sdf_file(path)
        return FoundModel(str(path.resolve()), _name(path.resolve().name), found, "sdf")
    if not path.is_file():
        beside = path.parent.iterdir() if path.parent.is_dir() else ()
        near = [p.name for p in beside if p.suffix in (*SUFFIXES, ".xml")] if path.suffix else []
        what = "a folder without model.config" if path.is_dir() else "there is no such file"
        what = "not a regular file" if path.exists() and not path.is_dir() else what
        raise ModelError(f"'{address}': {what}{did_you_mean(path.name, near)}")
    path = path.resolve()
    return FoundModel(str(path), _name(path.stem), path, _format(path))


def _format(path: Path) -> str:
    known = SUFFIXES.get(path.suffix.lower())
    if known is None and path.suffix.lower() == ".xml":
        from bt_manip.models.hardened_xml import read_xml

        known = {"mujoco": "mjcf", "robot": "urdf", "sdf": "sdf"}.get(str(read_xml(path).tag))
    if known is None:
        raise ModelError(
            f"{path}: not a model; one is MJCF (.xml), .urdf, .sdf, .obj, .stl or .dae"
        )
    return known


def _name(text: str) -> str:
    """Return a name that is valid in a cell, MuJoCo and a tree."""
    return re.sub(r"[^A-Za-z0-9_-]+", "_", text).strip("_") or "model"
