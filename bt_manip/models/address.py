"""Addresses of models, their files, and their conversion to MJCF."""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

from bt_manip.exceptions import BtManipError, did_you_mean
from bt_manip.models.bundled import bundled_path, bundled_root
from bt_manip.models.changed_mjcf import scaled_model
from bt_manip.models.downloads import Progress, terminal_progress
from bt_manip.models.errors import ModelError
from bt_manip.models.formats import ModelFormat, built_in_formats, recognise, root_tag
from bt_manip.models.found_model import FoundModel, MjcfModel, model_name
from bt_manip.models.menagerie import menagerie_file
from bt_manip.models.packages import find_package_file
from bt_manip.packages import missing
from bt_manip.registry import installed_parts

_SCALE, _NUMBER = "?scale=", re.compile(r"[0-9.]+([eE][+-]?[0-9]+)?")
_SUFFIXES = (".xml", ".urdf", ".sdf", ".obj", ".stl", ".dae")
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):")  # a single letter is a drive


def is_address(text: str) -> bool:
    """Return whether a text is an address, and not a registered name."""
    return not all(c.isalnum() or c in "_-" for c in text)


Source = Callable[[str, Progress], FoundModel | Path]
"""Function that returns the model of an address, or its path."""


def load_model(
    address: str,
    *,
    convex: str = "hull",
    progress: Progress = terminal_progress,
    sources: Mapping[str, Source] | None = None,
    formats: Mapping[str, ModelFormat] | None = None,
) -> MjcfModel:
    """Return the model of an address as MJCF; it is downloaded if needed.

    Args:
        address: As for `find_model`; ``?scale=0.001`` at the end multiplies all lengths.
        convex: Collision geometry of meshes: convex ``"hull"`` or convex ``"parts"``.
        progress: Called with the progress of a download.
        sources: As for `find_model`.
        formats: As for `find_model`.

    Raises:
        ModelError: If it cannot be found, fetched or converted.
    """
    if convex not in ("hull", "parts"):
        raise ModelError(f"meshes collide by their 'hull' or by 'parts', not by '{convex}'")
    found = find_model(address, progress, sources, formats)
    known = built_in_formats() if formats is None else formats
    if found.format not in known and formats is None:
        known = installed_parts().model_formats.copies()
    if found.format not in known:
        near = did_you_mean(found.format, known)
        raise ModelError(f"'{address}': unknown format '{found.format}'{near}")
    model = known[found.format].convert(found, convex=convex, progress=progress)
    _, given, factor = address.strip().partition(_SCALE)
    if not given:
        return model
    scale = float(factor) if _NUMBER.fullmatch(factor) else 0.0
    if not 0.0 < scale < math.inf:
        raise ModelError(f"'{address}': scale must be a positive number, got '{factor}'")
    return scaled_model(replace(model, address=f"{model.address}{_SCALE}{factor}"), scale)


def find_model(
    address: str,
    progress: Progress = terminal_progress,
    sources: Mapping[str, Source] | None = None,
    formats: Mapping[str, ModelFormat] | None = None,
) -> FoundModel:
    """Return the file of a model by its address; it is downloaded if it is not cached.

    Args:
        address: ``bundled:cube``, a path, ``package://NAME/PATH``, ``menagerie:NAME``, or an
            address of a plugin's source, such as ``fuel:OWNER/NAME``.
        progress: Called with the progress of a download.
        sources: Functions that find models, by the kind of address; default: `built_in_sources`,
            and those of installed plugins.
        formats: Formats by name; default: `built_in_formats`, and those of installed plugins.

    Raises:
        ModelError: If there is no such model, or it cannot be fetched.
    """
    text = address.strip().partition(_SCALE)[0]
    match = _SCHEME.match(text)
    scheme = match.group(1).lower() if match else ""
    known = built_in_sources() if sources is None else sources
    if scheme not in (*known, "file") and (not scheme or Path(text).exists()):
        return _file(text, Path(text), formats)
    if scheme == "file":
        return _file(text, Path(text[len("file:") :].removeprefix("//")), formats)
    if scheme not in known and sources is None:
        known = installed_parts().model_sources.copies()
    if scheme not in known:
        check_package(address, "model source", scheme)
        near = did_you_mean(f"{scheme}:", (f"{other}:" for other in known))
        raise ModelError(f"'{address}': unknown kind of address '{scheme}:'{near}")
    found = known[scheme](text, progress)
    if isinstance(found, Path):
        model = _file(str(found), found, formats)
        return model if scheme == "package" else replace(model, address=text)
    return found


def built_in_sources() -> dict[str, Source]:
    """Return the built-in sources, by kind of address."""
    return {
        "bundled": lambda address, progress: _bundled(address.partition(":")[2]),
        "menagerie": _menagerie,
        "package": lambda address, progress: find_package_file(address),
    }


def _menagerie(address: str, progress: Progress) -> FoundModel:
    rest = address.partition(":")[2]
    path = menagerie_file(rest, progress)
    return FoundModel(f"menagerie:{rest}", model_name(rest.partition("/")[0]), path, "mjcf")


def _bundled(name: str) -> FoundModel:
    stem = name.removesuffix(".xml")
    inside = f"{stem}.xml" if "/" in stem else f"{stem}/{stem}.xml"
    try:
        path = bundled_path(inside)
    except BtManipError:
        near = did_you_mean(stem, bundled_names())
        raise ModelError(f"no bundled model '{name}'{near}") from None
    return FoundModel(f"bundled:{name}", model_name(path.stem), path, "mjcf")


def bundled_names() -> list[str]:
    """Return the names of the models in the package."""
    files = bundled_root("models").glob("*/*.xml")
    return sorted(path.stem for path in files if path.stem == path.parent.name)


def _file(address: str, path: Path, formats: Mapping[str, ModelFormat] | None) -> FoundModel:
    path = path.expanduser()
    try:
        exists = path.is_file() or path.is_dir()
    except PermissionError as error:
        raise ModelError(f"'{address}': {error.strerror}") from None
    if not exists:
        beside = path.parent.iterdir() if path.parent.is_dir() else ()
        near = [p.name for p in beside if p.suffix in (path.suffix, *_SUFFIXES)]
        what = "not a regular file" if path.exists() else "there is no such file"
        raise ModelError(f"'{address}': {what}{did_you_mean(path.name, near)}")
    path = path.resolve()
    found = recognise(path, built_in_formats() if formats is None else formats)
    if found is None and formats is None:
        found = recognise(path, installed_parts().model_formats.copies())
    if found is None:
        inside = [file.name for file in path.glob("*")]  # of a folder
        names = inside or (path.suffix.lower(), root_tag(path))
        check_package(address, "file", *names)
        if path.is_dir():
            raise ModelError(f"'{address}': a folder without model.config")
        raise ModelError(
            f"{path}: not a model; one is MJCF (.xml), .urdf, .sdf, .obj, .stl or .dae"
        )
    name = path.name if path.is_dir() else path.stem
    return FoundModel(str(path), model_name(name), found[1], found[0])


def check_package(address: str, kind: str, *names: str) -> None:
    """Raise a `ModelError` that names the package which brings one of the unknown names, if any.

    For the kinds of names see `bt_manip.packages.packages`; they are the kind of an address, or
    suffix, root element or files of a path.
    """
    for name in names:
        if package := missing(kind, name):
            raise ModelError(f"'{address}' {package}")
