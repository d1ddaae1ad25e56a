"""Resolution of ``package://`` and ``model://``."""

import os
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import unquote

from bt_manip.exceptions import did_you_mean
from bt_manip.models.errors import ModelError

PACKAGE_VARIABLES = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH")
"""Environment variables of ROS and Gazebo that list folders of packages."""


def find_package_file(uri: str, near: Path | None = None) -> Path:
    """Return the file of ``package://NAME/PATH`` or ``model://NAME/PATH``.

    Packages are searched in the parent folders of the referring file, in the folders of the
    environment variables, and in the current folder.

    Args:
        uri: The URI.
        near: The file that contains the URI.

    Raises:
        ModelError: If there is no such package, or no such file in it.
    """
    _, _, rest = unquote(uri).partition("://")
    name, _, inside = rest.strip("/").partition("/")
    if not name or ".." in Path(rest).parts:
        raise ModelError(f"'{uri}': expected {uri.partition('://')[0]}://NAME/PATH")
    known: list[str] = []
    for folder in _places(name, near):
        known.append(folder.name)
        if folder.name == name and (folder / inside).exists():
            return folder / inside
    if name not in known:
        variables = ", ".join(PACKAGE_VARIABLES)
        raise ModelError(
            f"'{uri}': no package '{name}' near the file, in {variables}, or here"
            + did_you_mean(name, known)
        )
    raise ModelError(f"'{uri}': there is no '{inside}' in the package")


def _places(name: str, near: Path | None) -> Iterator[Path]:
    """Yield candidate folders of the package, and their siblings."""
    if near is not None:
        for parent in near.resolve().parents:
            if parent.name == name:
                yield parent
            if (parent / name).is_dir():
                yield parent / name
    for variable in PACKAGE_VARIABLES:
        for text in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            place = Path(text)
            if place.name == name:
                yield place
            for base in (place, place / "share"):
                if base.is_dir():
                    yield from (folder for folder in sorted(base.iterdir()) if folder.is_dir())
    if Path(name).is_dir():
        yield Path(name).resolve()
